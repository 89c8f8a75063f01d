#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# collect and load at what lines come from and go to: disks that fail, lines that nobody may read, sockets and instruments by socat and
# sigrok-cli, things without an end.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
here=$PWD
work=$(mktemp -d) || exit 2
others=()
trap '[ ${#others[@]} -gt 0 ] && kill "${others[@]}" 2>/dev/null; rm -rf "$work"' EXIT
chmod 755 "$work"
cd "$work" || exit 2
n=0 bad=0

ok() { # name condition-status [detail]
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; else bad=1; echo "not ok $n - $1"; [ -n "${3:-}" ] && printf '%s\n' "$3" | sed 's/^/#   /'; fi
}
skip() { n=$((n + 1)); echo "ok $n - $1 # SKIP $2"; } # name why
is() { # name wanted got
    [ "$2" = "$3" ]
    ok "$1" $? "wanted $2, got $3"
}
raw() { grep -v '^#' "$1" | cut -f 2-; }
swing() { awk -v n="$1" 'BEGIN { for (i = 0; i < n; i++) printf "%d,%.3f\n", 20 * i, 20 + 5 * cos(0.174 * i) }'; }
sensor() { "$hooke" --simulate-sensor spring rate=500 quirks=off time=s for=0.3s | tr -d '\r' >"$1"; }
await() { # file: it is there
    for _ in $(seq 400); do [ -e "$1" ] && return; sleep 0.05; done
}

# ---- a disk that fails
if ! strace -qq -o /dev/null true 2>/dev/null || [ "${CONFIG:-release}" = asan ]; then
    skip "a disk that fails" "strace cannot trace here"
else
    lies='' torn='' tries=0
    sensor reference.txt
    for fault in write:error=ENOSPC:when=1+ write:error=ENOSPC:when=3+ write:error=EIO:when=2 write:error=EINTR:when=3 fsync:error=EIO:when=1; do
        rm -f disk.txt
        tries=$((tries + 1))
        sensor /dev/stdout | timeout 240 strace -f -qq -o /dev/null -P "$work/disk.txt" -e inject="$fault" "$hooke" -n -c 'collect - to=disk.txt' \
            >disk.out 2>&1
        status=$?
        came=$([ -e disk.txt ] && raw disk.txt | wc -l || echo 0)
        { [ "$came" -eq 151 ] && [ "$status" -eq 0 ]; } || [ "$status" -eq 4 ] || lies+="$fault (status $status, $came lines) "
        [ ! -e disk.txt ] || raw disk.txt | cmp -s - <(head -n "$came" reference.txt) || torn+="$fault "
    done
    [ -z "$lies" ]
    ok "who lost a line says so by the status, $tries times" $? "$lies"
    [ -z "$torn" ]
    ok "what is in the file is whole lines" $? "$torn"
    mkfifo broken
    sensor broken 2>/dev/null &
    timeout 120 strace -f -qq -o /dev/null -P "$work/broken" -P broken -e inject=read:error=EIO:when=2+ "$hooke" -n -c 'collect broken to=read.txt' \
        >read.out 2>&1
    grep -q '(unplugged)' read.out && grep -q 'broken was disconnected: Input/output error' read.out
    ok "a device that fails is told from one that ends" $? "$(cat read.out)"
    wait
fi

# ---- a line that nobody may read
mkfifo closed
if [ "$(id -u)" -eq 0 ] && setpriv --reuid=65534 --regid=65534 --clear-groups test -x "$hooke" 2>/dev/null && chgrp dialout closed 2>/dev/null; then
    chmod 640 closed
    setpriv --reuid=65534 --regid=65534 --clear-groups "$hooke" -n -c "collect closed to=/tmp/hooke-none-$$.txt" >closed.out 2>&1
    is "who may not read a line is refused" 4 $?
    grep -q "the group 'dialout': 'sudo usermod -aG dialout" closed.out
    ok "and told the group to join" $? "$(cat closed.out)"
elif [ "$(id -u)" -ne 0 ]; then
    chmod 040 closed
    "$hooke" -n -c 'collect closed to=none.txt' >closed.out 2>&1
    is "who may not read a line is refused" 4 $?
    grep -q "the group '$(id -gn)': 'sudo usermod -aG $(id -gn)" closed.out
    ok "and told the group to join" $? "$(cat closed.out)"
else
    skip "who may not read a line is told the group" "no other user can run the program here"
fi

# ---- things without an end
mkfifo nobody slow
endless() { # seconds word command
    local begin status took
    begin=$(date +%s%N)
    timeout 120 "$hooke" -n -c "$3" >endless.out 2>&1 </dev/null
    status=$?
    took=$((($(date +%s%N) - begin) / 1000000))
    [ "$status" -eq 4 ] && grep -q "$2" endless.out && [ "$took" -lt $((10 * 1000 * $1)) ]
    ok "$3: $2" $? "status $status after $took ms: $(cat endless.out)"
}
endless 1 'is empty' 'load /dev/null'
endless 1 'not a text file' 'load /dev/zero'
endless 1 'not a text file' 'load /dev/urandom'
endless 1 'it is a directory' 'load .'
endless 1 'it is a pipe and no program writes to it' 'load nobody'
endless 1 'no table of numbers' 'load /proc/self/status'
while :; do echo 1 2; sleep 0.05; done >slow 2>/dev/null &
endless 2 'data keep arriving' 'load slow'
if [ "$(id -u)" -eq 0 ] && [ -r /proc/kmsg ] && timeout 5 dd if=/proc/kmsg of=/dev/null bs=64k count=1 iflag=nonblock 2>&1 | grep -q 'unavailable'; then
    endless 2 'data keep arriving\|no table of numbers' 'load /proc/kmsg'
else
    skip "load /proc/kmsg" "it is not there, or not silent"
fi
"$hooke" -n -c 'load -' <&- >input.out 2>&1
grep -q 'standard input is closed' input.out
ok "a closed standard input is said to be" $? "$(cat input.out)"
swing 100 | "$hooke" -n -c 'load - tunit=ms; measure period' >input.out 2>&1
grep -q '100 rows' input.out && grep -q '^T = ' input.out
ok "load - reads what a program writes, to its end" $? "$(cat input.out)"

# ---- sockets and lines by socat
if ! command -v socat >/dev/null; then
    skip "a pair of lines by socat" "socat is not installed"
    skip "sockets by socat" "socat is not installed"
else
    cat >device.sh <<'end'
sleep 1.2
awk 'BEGIN { for (i = 0; i < 300; i++) { printf "%d,%.3f\r\n", 20 * i, 20 + 5 * cos(0.174 * i); fflush() } }'
for _ in $(seq 400); do [ "$(grep -vc '^#' line.txt)" -ge 300 ] && break; sleep 0.05; done
end
    socat -u 'EXEC:bash device.sh' "PTY,link=$work/line,raw,echo=0,wait-slave" 2>socat.out &
    others+=($!)
    await line
    timeout 120 "$hooke" -n -c 'collect line tunit=ms unit=cm to=line.txt; measure period' >line.out 2>&1
    grep -q '300 lines, 300 samples (unplugged)' line.out && grep -q '^T = 0.722' line.out # 2 pi 20 ms / 0.174 = 722.2 ms
    ok "300 of 300 lines by a pair of socat, then it hangs up" $? "$(cat line.out socat.out)"
    swing 300 >swing.csv
    socat -u OPEN:swing.csv UNIX-LISTEN:port 2>/dev/null &
    others+=($!)
    await port
    timeout 120 socat -u UNIX-CONNECT:port - | "$hooke" -n -c 'collect - tunit=ms to=unix.txt' >unix.out 2>&1
    raw unix.txt | cmp -s - swing.csv
    ok "a UNIX socket before standard input" $? "$(cat unix.out)"
    mkfifo tcp
    socat -d -d -u OPEN:swing.csv TCP-LISTEN:0,bind=127.0.0.1 2>tcp.log &
    others+=($!)
    port=
    for _ in $(seq 100); do
        port=$(sed -n 's/.*listening on AF=2 127.0.0.1:\([0-9]*\)$/\1/p' tcp.log)
        [ -n "$port" ] && break
        sleep 0.05
    done
    if [ -z "$port" ]; then
        skip "a TCP port before a pipe" "no port of this machine can be listened at"
    else
        timeout 120 socat -u TCP:127.0.0.1:"$port" OPEN:tcp 2>/dev/null &
        others+=($!)
        timeout 120 "$hooke" -n -c 'collect tcp tunit=ms to=tcp.txt' >tcp.out 2>&1
        raw tcp.txt | cmp -s - swing.csv
        ok "a TCP port before a pipe" $? "$(cat tcp.out)"
    fi
fi

# ---- an instrument: sigrok-cli's demo device, a sine of 5 Hz at 100 samples a second
if ! command -v sigrok-cli >/dev/null; then
    skip "sigrok-cli's demo device" "without sigrok-cli, an optional judge"
elif ! sigrok-cli -d demo --config samplerate=100 --samples 3 -C A1 -O analog 2>/dev/null | grep -q '^A1: '; then
    skip "sigrok-cli's demo device" "it has no channel A1"
else
    demo() { timeout 120 sigrok-cli -d demo --config samplerate=100 --time 1500 -C A1 -O analog 2>/dev/null; }
    demo | "$hooke" -n -c 'collect - rate=100 for=10s to=demo.txt; measure period' >demo.out 2>&1
    grep -q '^T = 0.2000000\|^T = 200.0000' demo.out && grep -q 'A1 \[mV\]' demo.out
    ok "the demo device of sigrok-cli into standard input" $? "$(cat demo.out)"
    mkfifo demo
    demo >demo &
    "$hooke" -n -c 'collect demo rate=100 to=fifo.txt; measure period' >fifo.out 2>&1
    [ "$(raw fifo.txt | wc -l)" -eq "$(grep -o '[0-9]* samples' fifo.out | head -n 1 | cut -d ' ' -f 1)" ] && grep -q '^T = ' fifo.out
    ok "and into a pipe" $? "$(cat fifo.out)"
fi
# ---- the recipes of examples/collect, as they are written there
recipes=$here/examples/collect
if ! command -v python3 >/dev/null; then
    skip "phyphox.sh" "python3 is not installed"
elif ! command -v curl >/dev/null; then
    skip "phyphox.sh" "without curl, an optional program"
else
    cat >phone.py <<'end'
import http.server, math, sys
t = 0 # its own clock: however slow the machine is, it has a sample each 0.05 s
class Phone(http.server.BaseHTTPRequestHandler):
    def do_GET(self):
        global t
        t += 0.05
        buffers = ['"%s":{"size":0,"updateMode":"single","buffer":[%.6f]}' % one
                   for one in (("accY", math.sin(12 * t)), ("acc_time", t))]
        self.send_response(200)
        self.end_headers()
        self.wfile.write(('{"buffer":{%s},"status":{"session":"a","measuring":true}}'
                          % ",".join(buffers[::sys.argv[1] == "time" and -1 or 1])).encode())
    def log_message(self, *ignored):
        pass
server = http.server.HTTPServer(("127.0.0.1", 0), Phone)
open(sys.argv[1] + ".port", "w").write(str(server.server_port) + "\n")
while t < 1.7:
    server.handle_request()
end
    for order in time value; do
        python3 phone.py $order &
        others+=($!)
        await $order.port
        timeout 120 sh "$recipes/phyphox.sh" "127.0.0.1:$(cat $order.port)" 2>/dev/null |
            timeout 120 "$hooke" -n -c "collect - unit=m/s^2 for=100s to=phone-$order.txt; measure period" >phone.out 2>&1
        grep -q '^T = 0.52' phone.out # 2 pi / 12 = 0.5236 s
        ok "phyphox.sh with a phone that says its $order first" $? "$(cat phone.out)"
    done
fi
echo "1..$n"
exit "$bad"

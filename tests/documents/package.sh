#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The tarball has the same bytes each time, and all files of the commit; each file that is installed
# is in one Debian package. The long form builds the packages, asks lintian, and tries them in a
# minimal root where there is one to be had.
set -u
hooke=$(realpath "${HOOKE:-build/hooke}")
top=$(dirname "$hooke")
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
n=0 bad=0
ok() { # name condition-status [detail]
    n=$((n + 1))
    if [ "$2" -eq 0 ]; then echo "ok $n - $1"; return; fi
    bad=1
    echo "not ok $n - $1"
    [ -z "${3:-}" ] || printf '%s\n' "$3" | head -15 | sed 's/^/#   /'
}
skip() { n=$((n + 1)); echo "ok $n - $1 # SKIP $2"; }
unset MAKEFLAGS MAKEOVERRIDES MFLAGS
version=$("$hooke" --version | sed -n '1s/.* //p')

if git rev-parse -q --verify HEAD >/dev/null 2>&1; then
    make -s dist && mv "build/hooke-$version.tar.gz" "$work/first"
    ok "make dist" $?
    (umask 077 && make -s dist) && cmp "build/hooke-$version.tar.gz" "$work/first"
    ok "has the same bytes once more, under another umask" $?
    mkdir "$work/home"
    printf '[core]\n\tautocrlf = true\n\tattributesFile = %s\n[tar]\n\tumask = user\n' "$work/home/attributes" >"$work/home/.gitconfig"
    echo '*.md export-ignore' >"$work/home/attributes"
    said=$(git clone -q --no-local . "$work/another place" 2>&1 && cd "$work/another place" &&
        HOME=$work/home XDG_CONFIG_HOME=$work/home TZ=Asia/Kolkata LC_ALL=C make -s dist 2>&1 && cmp "build/hooke-$version.tar.gz" "$work/first" 2>&1)
    ok "and from another clone, by who has git change lines and leave files out, elsewhere in the world" $? "$said"
    [ "$(od -An -tx1 -j4 -N4 "$work/first" | tr -d ' ')" = 00000000 ] &&
        [ "$(TZ=UTC tar --full-time -tvzf "$work/first" | awk '{print $4, $5}' | sort -u | wc -l)" -eq 1 ]
    ok "and no time but the commit's" $?
    said=$(tar -tzf "$work/first" | sed -n "s,^hooke-$version/\(.*[^/]\)$,\1,p" | sort |
        diff - <(git ls-tree -r --name-only HEAD | sort))
    [ -z "$said" ]
    ok "and every file of the commit, and no other" $? "$said"
else
    skip "make dist" "this is no clone"
fi
[ "$(sed -n '1s/.*(\(.*\)-[^-]*).*/\1/p' scripts/package/debian/changelog)" = "$version" ]
ok "the package is of this version" $?

# The build that is under test, as it is.
building=(TOP="${top#"$PWD/"}" CONFIG="${CONFIG:-release}" DESTDIR="$work/root" PREFIX=/usr
    LIBDIR=/usr/lib/here)
case $top in */plain | */plain-*) building+=(OPTIONAL=no) ;; esac
said=$(make -s "${building[@]}" install 2>&1)
ok "make install where Debian has its libraries" $? "$said"
grep -qx 'libdir=/usr/lib/here' "$work/root/usr/lib/here/pkgconfig/hooke.pc"
ok "and pkg-config is told" $?
said=$(cd "$work/root" && find . ! -type d | sed 's,^./,,' | while read -r file; do
    count=0
    for list in "$OLDPWD"/scripts/package/debian/*.install; do
        while read -r pattern; do
            # shellcheck disable=SC2254
            case $file in $pattern | $pattern/*) count=$((count + 1)) ;; esac
        done <"$list"
    done
    [ "$count" -eq 1 ] || echo "$file is in $count packages"
done)
[ -z "$said" ]
ok "each of $(find "$work/root" ! -type d | wc -l) files is in one package" $? "$said"

if [ -n "${LONG:-}" ]; then
    if command -v lintian >/dev/null && command -v dh >/dev/null; then
        said=$(scripts/package/build 2>&1)
        ok "the packages are built, and lintian finds no error" $? "$said"
        if [ "$(id -u)" -eq 0 ] && command -v mmdebstrap >/dev/null; then
            said=$(scripts/package/try 2>&1)
            ok "they install, run, upgrade and go" $? "$said"
        else
            skip "in a minimal root" "that takes root and mmdebstrap"
        fi
    else
        skip "the packages" "lintian or debhelper is not there (scripts/install-packages --packages)"
    fi
fi
echo "1..$n"
exit "$bad"

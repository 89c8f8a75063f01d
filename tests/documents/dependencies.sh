#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# What make builds again when a library appears or goes, or when the compiler or its flags change:
# what depends on that, and nothing else. In a small tree of its own, where nothing is compiled
# (make -t) and another pkg-config answers.
# needs "modules/pictures/"
set -u
work=$(mktemp -d) || exit 2
trap 'rm -rf "$work"' EXIT
n=0 bad=0
is() { # name got wanted
    n=$((n + 1))
    if [ "$2" = "$3" ]; then echo "ok $n - $1"; return; fi
    bad=1
    echo "not ok $n - $1"
    echo "#   built again: $2; expected: $3"
}

mkdir -p "$work"/tree/src/{base,modules/pictures/surface,terminal,method/rows} "$work/bin"
mkdir "$work/tree/scripts"
cp Makefile "$work/tree"
cp scripts/modules "$work/tree/scripts"
for file in src/main.c src/base/{arena,error}.c src/modules/pictures/surface/cairo_surface.c src/terminal/screen.c src/method/rows/catalog.c; do
    cp "$file" "$work/tree/$file"
done
cat >"$work/bin/pkg-config" <<'END'
#!/bin/sh
case "$*" in
--exists*cairo*) exec test -e "$ANSWERS/cairo" ;;
--exists*) exit 1 ;;
--cflags*readline*) cat "$ANSWERS/line" 2>/dev/null ;;
--libs*gsl*) cat "$ANSWERS/gsl" 2>/dev/null || echo -lgsl -lgslcblas -lm ;;
esac
END
printf '#!/bin/sh\ncase "$*" in --version) echo "gcc (another) 99.1" ;; *) exec gcc "$@" ;; esac\n' >"$work/bin/newer-gcc"
chmod +x "$work"/bin/*
export ANSWERS=$work PATH=$work/bin:$PATH
unset MAKEFLAGS MAKEOVERRIDES MFLAGS TOP CONFIG OPTIONAL WERROR CC CFLAGS_EXTRA
cd "$work/tree" || exit 2

# What would be built, by name; from then on it is taken for built.
again() { # make's arguments...
    make -t CONFIG=debug "$@" build/debug/hooke | sed -n 's,^touch .*/\(.*\)$,\1,p' | sort | tr '\n' ' '
}
all='arena.o cairo_surface.o catalog.o error.o hooke libhooke.a main.o screen.o '
again >/dev/null
touch "$work/cairo"
is 'a library appears: what uses it' "$(again)" 'cairo_surface.o catalog.o hooke libhooke.a '
touch Makefile
is 'and then all is built, whatever else the makefile says' "$(again)" ''
rm "$work/cairo"
is 'it goes: the same' "$(again)" 'cairo_surface.o catalog.o hooke libhooke.a '
echo -I/elsewhere >"$work/line"
is 'its headers move: who includes them' "$(again)" 'hooke screen.o '
echo '-lgsl -lm' >"$work/gsl"
is 'a library is linked in another way' "$(again)" 'hooke '
is 'the compiler is another one' "$(again CC=newer-gcc)" "$all"
is 'flags are other ones' "$(again CC=newer-gcc CFLAGS_EXTRA=-DNOTHING)" "$all"
is 'warnings that are errors give the same objects' \
    "$(again CC=newer-gcc CFLAGS_EXTRA=-DNOTHING WERROR=1)" ''
echo "1..$n"
exit $bad

# SPDX-License-Identifier: GPL-3.0-or-later
# hooke: one non-recursive makefile. `make help` lists what it can do.

CONFIG  ?= release
CC      ?= gcc
V       ?= 0
PREFIX  ?= /usr/local
DESTDIR ?=
HOOKE_DATA ?= ../shared/data
HOOKE_NIST ?= ../shared/nist
VERSION := 0.1.0

# Layers, left to right: an include may only go left, and each layer's tests link without the layers to its right.
LIBRARY_LAYERS := base result scene method run data figure
PROGRAM_LAYERS := session language plot report command modules view api terminal
LAYERS := $(LIBRARY_LAYERS) $(PROGRAM_LAYERS)

# A folder of src/modules is a capability that a build can leave out: make WITHOUT="NAME ...", or WITHOUT=all.
WITHOUT     ?=
ALL_MODULES := $(sort $(notdir $(patsubst %/,%,$(wildcard src/modules/*/))))
LEFT_OUT    := $(if $(filter all,$(WITHOUT)),$(ALL_MODULES),$(sort $(WITHOUT)))
MODULES     := $(filter-out $(LEFT_OUT),$(ALL_MODULES))
ifneq ($(filter-out $(ALL_MODULES),$(LEFT_OUT)),)
$(error no module is called $(filter-out $(ALL_MODULES),$(LEFT_OUT)); there are: $(ALL_MODULES))
endif

Q := $(if $(filter 1,$(V)),,@)
say = $(if $(filter 1,$(V)),,$(info $() $() $(1) $(2)))

# ---- flags: each is probed once ---------------------------------------------------------------------------------------

probe = $(shell echo 'int main(void){return 0;}' | $(CC) -Werror $(1) -x c -o /dev/null - >/dev/null 2>&1 && echo '$(1)')

# The same of a linker's flag, which the C library has to understand as well.
comma := ,
probe_run = $(shell at=$$(mktemp) && \
  echo 'int f(void); int (*p)(void) = f; int f(void) {return p != f;} int main(void) {return p();}' | \
  $(CC) -fPIE -pie -Wl,--fatal-warnings $(1) -x c -o $$at - >/dev/null 2>&1 && $$at && echo '$(1)'; rm -f $$at)

WARNINGS := -Wall -Wextra -Wpedantic -Wformat=2 -Wconversion -Wsign-conversion -Wshadow -Wvla -Wnull-dereference \
  -Wimplicit-fallthrough -Wdouble-promotion -Wundef -Wcast-qual -Wstrict-prototypes -Wmissing-prototypes -Wwrite-strings \
  -Werror=implicit -Werror=int-conversion $(if $(WERROR),-Werror)
NUMBERS := -ffp-contract=off
HARDEN  := -fno-common -fno-delete-null-pointer-checks -fstack-protector-strong $(call probe,-fstack-clash-protection) \
  $(call probe,-fcf-protection=full)
FORTIFY := -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=3
LDHARDEN := -pie -Wl,-z,relro,-z,now,-z,noexecstack,--as-needed $(call probe_run,-Wl$(comma)-z$(comma)pack-relative-relocs)

# Line numbers only, and no tables for unwinding by exceptions, which C has none of.
OPT_release  := -O2 -g1 -fno-asynchronous-unwind-tables $(FORTIFY)
OPT_asan     := -O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer
OPT_coverage := -O0 -g --coverage
# For its warnings: those of clang are the same without optimisation, in half the time.
OPT_clang    := -O0
OPT_debug    := -O0 -g
# The targets of tests/fuzz, guided by coverage (clang's libFuzzer).
OPT_fuzz     := -O1 -g1 -fno-omit-frame-pointer -fsanitize=address,undefined,fuzzer-no-link \
  -fno-sanitize-recover=undefined
# Ends where 50 ms pass without a look at the flag of Ctrl-C.
OPT_watch    := -O2 -g -DHOOKE_WATCH -fno-omit-frame-pointer $(FORTIFY)

PKG := pkg-config
GSL_CFLAGS  := $(shell $(PKG) --cflags gsl 2>/dev/null)
GSL_LIBS    := $(shell $(PKG) --libs gsl 2>/dev/null || echo -lgsl -lgslcblas -lm)
# The program has GSL from its archives where there are any: a library of its size is most of what a start relocates.
GSL_ARCHIVES := $(shell echo 'double gsl_hypot(double, double); int main(int c, char **v) { return gsl_hypot(c, !v) > 9; }' | \
  $(CC) -fPIE -pie -x c -o /dev/null - -l:libgsl.a -l:libgslcblas.a -lm >/dev/null 2>&1 && \
  echo -l:libgsl.a -l:libgslcblas.a)
LINE_CFLAGS := $(shell $(PKG) --cflags readline ncursesw 2>/dev/null)
LINE_LIBS   := $(shell $(PKG) --libs readline ncursesw 2>/dev/null || echo -lreadline -lncursesw -ltinfo)
TEST_LIBS   := $(shell $(PKG) --libs cmocka 2>/dev/null || echo -lcmocka)

# Optional libraries are used where they are installed; OPTIONAL=no leaves them all out.
OPTIONAL ?= yes
ifneq ($(OPTIONAL),no)
# Never linked: loaded when a picture is drawn.
CAIRO_CFLAGS := $(shell $(PKG) --exists cairo-svg cairo-pdf cairo-png 2>/dev/null && echo -DHAVE_CAIRO $$($(PKG) --cflags cairo))
# CVODE to compare with: its archives, so that the program does not start more slowly.
SUNDIALS_LIBS := $(foreach l,cvode sunlinsoldense sunnonlinsolfixedpoint sunmatrixdense nvecserial,-l:libsundials_$(l).a)
SUNDIALS_LIBS := $(shell \
  echo '_Static_assert(SUNDIALS_VERSION_MAJOR == 6, ""); int main(void) { return !CVodeCreate(CV_BDF, 0); }' | \
  $(CC) -include cvode/cvode.h -x c -o /dev/null - $(SUNDIALS_LIBS) -lm >/dev/null 2>&1 && echo '$(SUNDIALS_LIBS)')
# Loaded when a recording is in such a file.
CONTAINER_CFLAGS := $(foreach l,archive expat freexl,$(shell p=$(if $(filter archive,$(l)),libarchive,$(l)); \
  $(PKG) --exists $$p 2>/dev/null && echo -DHAVE_$(shell echo $(l) | tr a-z A-Z) $$($(PKG) --cflags $$p)))
endif
OPTIONAL_CPPFLAGS := $(CONTAINER_CFLAGS) $(CAIRO_CFLAGS) $(if $(SUNDIALS_LIBS),-DHOOKE_SUNDIALS)
# What is compiled with them.
OPTIONAL_SOURCES := $(wildcard src/modules/pictures/surface/*.c tests/modules/pictures/*.c) src/method/rows/catalog.c src/method/step/cvode.c \
  $(addprefix src/modules/recording/container/,archive.c xml.c workbook_old.c) $(wildcard tests/modules/recording/data/container*.c) \
  tests/modules/pixels/pixels.c
# Tests that say something else with them than without.
OPTIONAL_TESTS = $(shell grep -liE 'cairo|cvode|libarchive|"\# needs' $(TEST_SOURCES) $(TEST_SCRIPTS))

CPPFLAGS += -D_DEFAULT_SOURCE -D_FILE_OFFSET_BITS=64 -D_TIME_BITS=64 -DHOOKE_VERSION='"$(VERSION)"' -Iinclude -Isrc -Ibuild
TEST_CPPFLAGS := -D_GNU_SOURCE -Itests $(if $(filter fuzz,$(CONFIG)),-DFUZZING)
CFLAGS   := -std=c11 $(OPT_$(CONFIG)) $(WARNINGS) $(NUMBERS) $(HARDEN) -fPIC -fvisibility=hidden $(CFLAGS_EXTRA)
LDFLAGS  := $(patsubst %-no-link,%,$(filter -fsanitize% --coverage,$(OPT_$(CONFIG)))) $(LDHARDEN) $(LDFLAGS_EXTRA)
LIBS     := $(SUNDIALS_LIBS) $(GSL_LIBS) -lm -ldl
PROGRAM_LIBS := $(SUNDIALS_LIBS) $(or $(GSL_ARCHIVES),$(GSL_LIBS)) -lm -ldl

# ---- what there is ----------------------------------------------------------------------------------------------------

# D: programs, and the objects that optional libraries or lists of modules change. All other objects are shared, in B.
empty :=
space := $(empty) $(empty)
B   := build/$(CONFIG)
D   := $(if $(filter no,$(OPTIONAL)),build/plain$(if $(filter release,$(CONFIG)),,-$(CONFIG)),$(B))
D   := $(if $(LEFT_OUT),$(D)-without/$(if $(MODULES),$(subst $(space),+,$(LEFT_OUT)),all),$(D))
TOP := $(if $(filter build/release,$(D)),build,$(D))

# What they were built with: see "objects" below.
FLAGS_STAMP    := $(B)/flags
LINE_STAMP     := $(B)/line
LINK_STAMP     := $(D)/link
OPTIONAL_STAMP := $(D)/optional

# What only the static program has: it takes nothing from the system that it runs on.
ALONE  := $(wildcard src/terminal/alone/*.c)
STATIC := build/static$(if $(filter release,$(CONFIG)),,-$(CONFIG))/hooke

# What is compiled with the lists of modules that are in: $(D)/lists/*.def, written by scripts/modules.
LIST_SOURCES := src/session/modules.c src/command/commands.c src/language/choices.c src/plot/plots.c \
  src/report/results.c src/report/table_kinds.c src/command/session/topics.c src/command/finding.c src/session/settings.c \
  src/terminal/parts.c \
  src/modules/recording/formats/formats.c src/modules/report/lesson_steps.c
ABSENT := $(wildcard $(foreach m,$(LEFT_OUT),src/modules/$(m)/*.c src/modules/$(m)/*/*.c))
$(shell scripts/modules $(D)/lists $(MODULES))
ifneq ($(.SHELLSTATUS),0)
$(error the list of modules was not written)
endif

# Objects of sources: src/PATH.c is $(B)/PATH.o, tests/PATH.c is $(B)/tests/PATH.o.
object   = $(foreach s,$(1),$(if $(filter $(OPTIONAL_SOURCES) $(LIST_SOURCES),$(s)),$(D),$(B))/$(patsubst src/%,%,$(s:.c=.o)))
# A module's folder `terminal` belongs to the terminal layer.
PARTS    := $(wildcard src/modules/*/terminal/*.c)
objects  = $(call object,$(filter-out $(ALONE) $(ABSENT) $(if $(filter modules,$(1)),$(PARTS)),$(sort \
  $(wildcard src/$(1)/*.c src/$(1)/*/*.c src/$(1)/*/*/*.c) $(if $(filter terminal,$(1)),$(PARTS)))))
upto     = $(if $(filter $(1),$(firstword $(2))),$(1),$(firstword $(2)) $(call upto,$(1),$(wordlist 2,99,$(2))))

# Terminals that the program describes where the system does not: compiled entries of terminfo(5), each as the value that
# TERMINFO may have.
TERMINALS := xterm xterm-256color screen screen-256color tmux tmux-256color linux vt100 vt220
build/terminals.def: build/terminals
	@for t in $(TERMINALS); do \
	  infocmp -q -x -Q2 $$t 2>/dev/null | tr -d '\n' | od -An -v -tu1 | tr -s ' \n' ',' | \
	    sed "s/^,*\(.*[0-9]\),*$$/{\"$$t\", (const char[]){\1,0}},\n/"; done >$@

# Texts that people read, as rows of C: src/PATH.txt is build/texts/PATH.def.
TEXTS := $(patsubst src/%.txt,build/texts/%.def,$(wildcard src/*/*.txt src/*/*/*.txt))
$(TEXTS): build/texts/%.def: src/%.txt scripts/texts
	@mkdir -p $(@D)
	@awk -f scripts/texts $< >$@
texts: $(TEXTS)

# The library is all but the terminal; programs use its api, or the layers as far as figure.
LIBRARY_OBJECTS := $(foreach l,$(filter-out terminal,$(LAYERS)),$(call objects,$(l)))
PROGRAM_OBJECTS := $(call objects,terminal) $(B)/main.o \
  $(if $(filter watch,$(CONFIG)),$(B)/tests/cancel/watch.o)

# Tests that need a module that is not in.
NEEDING := $(file <$(D)/lists/needing)
TEST_SOURCES := $(sort $(filter-out $(NEEDING),$(wildcard $(foreach kind,unit numerics data faults growth terminal,tests/$(kind)/*/*.c) \
  tests/fuzz/*.c $(foreach m,$(MODULES),tests/modules/$(m)/*.c tests/modules/$(m)/*/*.c))))
TEST_PROGRAMS := $(patsubst tests/%.c,$(D)/tests/%,$(TEST_SOURCES))
STORY_PROGRAMS := $(D)/tests/unit/command/scripts $(filter $(D)/tests/faults/%,$(TEST_PROGRAMS))
TEST_SCRIPTS := $(sort $(filter-out $(NEEDING),$(wildcard tests/*/*.sh $(foreach m,$(MODULES),tests/modules/$(m)/*.sh))))
FUZZERS      := $(patsubst tests/fuzz/%.c,%,$(filter tests/fuzz/%,$(TEST_SOURCES)))

.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
.SUFFIXES:

$(LIBRARY_OBJECTS): | $(TEXTS)

# Manual pages and completion, from the program's own rows.
PAGES := $(patsubst scripts/pages/%,$(TOP)/pages/%,$(wildcard scripts/pages/*))
EXAMPLES := $(sort $(wildcard examples/*.hk examples/*/*.hk examples/typed/*.ode examples/cluster/* examples/collect/* examples/library/*))

EDITORS := $(addprefix $(TOP)/pages/hooke.,bash vim nano)

all: $(TOP)/libhooke.a $(TOP)/libhooke.so.0 $(TOP)/hooke $(PAGES) $(EDITORS) ## build the library, the program, its manual and completion

$(TOP)/libhooke.a: $(LIBRARY_OBJECTS)
	$(call say,AR,$@)
	$(Q)rm -f $@ && ar rcs $@ $^

# Only what api.h declares can be seen of it.
$(TOP)/libhooke.so.0: $(call objects,api) $(TOP)/libhooke.a src/api/libhooke.map $(LINK_STAMP)
	$(call say,LINK,$@)
	$(Q)$(CC) -shared $(filter-out -pie,$(LDFLAGS)) -Wl,-soname,$(@F) -Wl,--version-script=src/api/libhooke.map -o $@ \
	  $(filter %.o %.a,$^) $(LIBS)

$(TOP)/hooke: $(PROGRAM_OBJECTS) $(TOP)/libhooke.a $(LINK_STAMP)
	$(call say,LINK,$@)
	$(Q)$(CC) $(LDFLAGS) -o $@ $(filter %.o %.a,$^) $(LINE_LIBS) $(PROGRAM_LIBS)

$(PAGES): $(TOP)/pages/%: scripts/pages/% $(TOP)/hooke scripts/reference $(EXAMPLES)
	$(call say,PAGE,$@)
	@mkdir -p $(@D)
	$(Q)scripts/reference page $* $(TOP)/hooke > $@

# What shells and editors know of it.
$(EDITORS): $(TOP)/pages/hooke.%: $(TOP)/hooke scripts/reference
	$(call say,PAGE,$@)
	@mkdir -p $(@D)
	$(Q)scripts/reference $* $(TOP)/hooke > $@

# The objects of the program without optional libraries, which would be loaded from the system; not position-independent:
# nothing is relocated as it starts. Stripped into a copy: pages of a file that was written in order are mapped in fewer pieces.
ifeq ($(OPTIONAL),no)
$(STATIC): $(PROGRAM_OBJECTS) $(call object,$(ALONE)) $(TOP)/libhooke.a $(dir $(STATIC))libreadline.a $(LINK_STAMP)
	$(call say,LINK,$@)
	$(Q)$(CC) -static -no-pie -Wl,-z,noexecstack,--gc-sections,--fatal-warnings,--wrap=setlocale,--wrap=dlsym -o $@.whole \
	  -L$(@D) $(filter %.o %/libhooke.a,$^) $(LINE_LIBS) $(LIBS)
	$(Q)strip -o $@ $@.whole && rm $@.whole

# Readline's archive where each function that is weak in ours is weak, too, and there as own_NAME besides.
$(dir $(STATIC))libreadline.a: $(B)/terminal/line.o
	@mkdir -p $(@D)
	$(Q)cp "$$($(CC) -print-file-name=libreadline.a)" $@ && cd $(@D) && nm $(abspath $^) | awk '$$2 == "W" {print $$3}' | \
	while read -r name; do \
	  nm -A libreadline.a 2>/dev/null | awk -F '[: ]' -v name=$$name '$$NF == name && $$(NF - 1) == "T" {print $$2, $$3}' | \
	  { read -r member at && ar x libreadline.a $$member && \
	    objcopy --weaken-symbol=$$name --add-symbol own_$$name=.text:0x$$at,function,global $$member && \
	    ar r libreadline.a $$member && rm $$member; } || exit; done
endif

static: ## one static program that needs nothing of the system it runs on: build/static/hooke
	$(Q)$(MAKE) --no-print-directory OPTIONAL=no $(STATIC)

# ---- optimisation, by what is compiled --------------------------------------------------------------------------------
# -O2 but for these, where the configuration is for speed at all:

# What goes once through a command, a table, a picture or a screen, and not once through each step: a quarter shorter.
# What studies evaluate at each step is not among it, nor what modules compute in their folders `compute` and these.
COMPUTED := clean container fit formats law lines modes period series table
EACH := $(patsubst src/%.c,$(B)/%.o,$(wildcard $(foreach f,compute $(COMPUTED),src/modules/*/$(f)/*.c))) $(B)/scene/typed/parts.o
ONCE := $(filter-out $(EACH),$(foreach l,result scene/typed figure $(PROGRAM_LAYERS),$(call objects,$(l)))) $(B)/main.o
# Loops over many steps: unrolled and vectorised.
LOOPS := $(addprefix $(B)/,run/many.o run/propagate.o run/energy/work.o run/energy/ledger.o modules/recording/law/equation.o)
# In vectors, twice: loops for what remains of a block are not worth their length.
WORK_TERMS := $(B)/run/energy/work_terms.o
LANES := $(patsubst src/%.c,$(B)/%.o,$(wildcard src/modules/lanes/compute/*.c))
KERNELS := $(patsubst src/%.c,$(B)/%.o,$(wildcard src/method/kernel/*.c src/modules/lanes/compute/shapes.c))
# Of these, those that gain by -O3: in the others the force is waited for.
FAST_KERNELS := $(filter $(addprefix %/,kernel.o controlled.o adapt.o rosenbrock.o),$(KERNELS))

ifneq ($(filter -O2,$(OPT_$(CONFIG))),)
# Without the passes that take longest to compile.
O_ONCE          := -Os $(call probe,-fno-expensive-optimizations -fno-gcse -fno-tree-pre -fno-tree-vrp \
  -fno-schedule-insns2 -fno-code-hoisting)
O_LOOPS         := -O3
O_WORK_TERMS    := -ftree-vectorize $(call probe,-fvect-cost-model=dynamic) $(call probe,--param=vect-epilogues-nomask=0)
O_LANES         := -O3
O_FAST_KERNELS  := -O3
endif
O_LANES += -fno-math-errno
# Packing position and velocity into one register lengthens the chain from step to step. Roots without a way out to a
# library that would say what is wrong with them: nothing reads that. Hundreds of unrolled bodies: under the sanitizers
# they would take minutes to compile; the general path, which gives the same bits, is instrumented.
O_KERNELS += $(call probe,-fno-tree-slp-vectorize) -fno-math-errno $(if $(findstring sanitize,$(OPT_$(CONFIG))),-fno-sanitize=all)

# What stands before functions of readline (src/terminal/line.c) and, in tests, of the C library has to be seen by those.
SEEN   := $(call objects,terminal) $(call object,$(TEST_SOURCES))
O_SEEN := -fvisibility=default

KINDS := ONCE LOOPS WORK_TERMS LANES KERNELS FAST_KERNELS SEEN
ifeq ($(CONFIG),fuzz)
# What is compared there are numbers that no input has.
COMPUTING := $(filter-out $(KERNELS),$(foreach l,scene method run modules,$(call objects,$(l))))
O_COMPUTING := -fno-sanitize-coverage=trace-cmp
KINDS += COMPUTING
endif
$(foreach kind,$(KINDS),$(eval $($(kind)): CFLAGS += $(O_$(kind))))

# ---- objects ----------------------------------------------------------------------------------------------------------
# Where the compiler, its flags or what is known of a library changes, what depends on it is built again: a file of one
# line that is written when the line is another one, as make reads this.

DIRECTORIES := $(sort $(dir $(LIBRARY_OBJECTS) $(PROGRAM_OBJECTS) $(call object,$(TEST_SOURCES) $(ALONE)) $(TEST_PROGRAMS)))
$(shell mkdir -p $(DIRECTORIES))

equal = $(if $(subst <$(1)>,,<$(2)>),,yes)
stamp = $(if $(and $(wildcard $(1)),$(call equal,$(strip $(file <$(1))),$(strip $(2)))),,$(file >$(1),$(strip $(2))))

# The compiler by its version: cc, gcc and ccache gcc are one.
COMPILER := $(filter -%,$(CC)) $(wordlist 2,99,$(shell $(CC) --version | head -1))
$(call stamp,$(FLAGS_STAMP),$(filter-out -Werror,$(COMPILER) $(CPPFLAGS) $(TEST_CPPFLAGS) $(CFLAGS) $(GSL_CFLAGS)) \
  $(foreach kind,$(KINDS),$(kind) $(O_$(kind))))
$(call stamp,build/terminals,$(TERMINALS))
$(call stamp,$(LINE_STAMP),$(LINE_CFLAGS))
$(call stamp,$(LINK_STAMP),$(LDFLAGS) $(LINE_LIBS) $(LIBS) $(PROGRAM_LIBS) $(TEST_LIBS))
$(call stamp,$(OPTIONAL_STAMP),$(OPTIONAL_CPPFLAGS) $(SUNDIALS_LIBS))

# Only the terminal's files see curses and readline.
LINE_OBJECTS := $(call objects,terminal)
$(LINE_OBJECTS): CPPFLAGS += $(LINE_CFLAGS)
$(LINE_OBJECTS): $(LINE_STAMP)

compile_source = $(CC) $(CPPFLAGS) $(GSL_CFLAGS) $(CFLAGS) -MMD -MP -c -o $@ $<

$(B)/%.o: src/%.c $(FLAGS_STAMP)
	$(call say,CC,$<)
	$(Q)$(compile_source)

$(B)/terminal/screen.o: build/terminals.def

# The lessons are in the program, too.
$(call object,src/modules/report/lesson_steps.c): $(wildcard examples/lessons/*.hk)
# So are the templates of programs.
$(call object,src/modules/programs/template.c): $(wildcard src/modules/programs/*.template)

OPTIONAL_OBJECTS := $(call object,$(OPTIONAL_SOURCES))
$(OPTIONAL_OBJECTS): CPPFLAGS += $(OPTIONAL_CPPFLAGS)
$(OPTIONAL_OBJECTS): $(OPTIONAL_STAMP)
LIST_OBJECTS := $(call object,$(LIST_SOURCES))
$(LIST_OBJECTS): CPPFLAGS += -I$(D)
ifneq ($(D),$(B))
$(filter-out $(D)/tests/%,$(OPTIONAL_OBJECTS) $(LIST_OBJECTS)): $(D)/%.o: src/%.c $(FLAGS_STAMP)
	$(call say,CC,$<)
	$(Q)$(compile_source)
endif

optional: ## the optional libraries that this build uses
	@echo $(strip $(if $(CAIRO_CFLAGS),cairo) $(shell echo $(patsubst -DHAVE_%,%,$(filter -DHAVE_%,$(CONTAINER_CFLAGS))) | tr A-Z a-z) $(if $(SUNDIALS_LIBS),sundials))

# ---- tests ------------------------------------------------------------------------------------------------------------
# tests/<kind>/<layer>/<subject>.c is linked with the layers up to <layer> only, where that is one that modules build on;
# with all of the library else.

compile_test = $(CC) $(CPPFLAGS) $(TEST_CPPFLAGS) $(GSL_CFLAGS) $(CFLAGS) -MMD -MP -c -o $@ $<

$(B)/tests/%.o: tests/%.c $(FLAGS_STAMP)
	$(call say,CC,$<)
	$(Q)$(compile_test)

ifneq ($(D),$(B))
$(filter $(D)/tests/%,$(OPTIONAL_OBJECTS)): $(D)/tests/%.o: tests/%.c $(FLAGS_STAMP)
	$(call say,CC,$<)
	$(Q)$(compile_test)
endif

layer_of = $(if $(findstring fuzz/,$(1)),$(if $(findstring fuzz/keys,$(1)),terminal,view),$(if \
  $(findstring modules/,$(1)),$(if $(findstring /terminal/,$(1)),terminal,modules),$(word 2,$(subst /, ,$(1)))))
linked = $(foreach l,$(call upto,$(if $(filter $(LIBRARY_LAYERS) terminal,$(1)),$(1),api),$(LAYERS)),$(call objects,$(l)))

.SECONDEXPANSION:
$(TEST_PROGRAMS): $(D)/tests/%: $$(call object,tests/%.c) \
  $$(call linked,$$(call layer_of,$$*)) $(LINK_STAMP)
	$(call say,LINK,$@)
	$(Q)$(CC) $(LDFLAGS) -o $@ $(filter %.o,$^) $(if $(filter terminal,$(call layer_of,$*)),$(LINE_LIBS)) $(TEST_LIBS) $(LIBS)

# The static program is tried where it is built from what is there anyway, and where its libraries' archives are.
TRIED_STATIC = $(if $(and $(filter build/plain,$(D)),$(shell echo 'int main(void){return 0;}' | \
  $(CC) -static -x c -o /dev/null - $(LINE_LIBS) $(LIBS) >/dev/null 2>&1 && echo yes)),$(STATIC))

tests-build: $(TOP)/hooke $(TOP)/libhooke.a $(TEST_PROGRAMS) $$(TRIED_STATIC)

RUN_TESTS = STATIC='$(TRIED_STATIC)' HOOKE=$(TOP)/hooke LIBHOOKE=$(TOP)/libhooke.a HOOKE_DATA='$(HOOKE_DATA)' HOOKE_NIST='$(HOOKE_NIST)' \
  CONFIG=$(CONFIG) LONG=$(LONG) scripts/run-tests

# FILTER: files whose path contains one of its words.
filtered = $(if $(FILTER),$(sort $(foreach word,$(FILTER),$(foreach test,$(1),$(if $(findstring $(word),$(test)),$(test))))),$(1))

check: $(call filtered,$(TEST_PROGRAMS)) $(TOP)/hooke $(TOP)/libhooke.a $$(TRIED_STATIC) ## the quick tests (FILTER="events fit": files with these words in their paths)
	$(Q)$(RUN_TESTS) $(call filtered,$(TEST_PROGRAMS) $(TEST_SCRIPTS))

# The tests of one layer: check-run, check-data, check-terminal ...
$(addprefix check-,$(sort $(LAYERS) $(MODULES))): check-%:
	$(Q)$(MAKE) --no-print-directory check FILTER='/$*/'

check-optional: tests-build ## the tests that depend on optional libraries (OPTIONAL=no: a build without them)
	$(Q)$(RUN_TESTS) $(foreach t,$(OPTIONAL_TESTS),$(if $(filter %.c,$(t)),$(t:tests/%.c=$(D)/tests/%),$(t)))

check-all: ## the long forms: every allocation, every system call, many synthetic recordings
	$(Q)$(MAKE) --no-print-directory check LONG=1

# Scripts of which nothing depends on how the program was compiled: texts, packages, what is installed.
SAME_SCRIPTS := $(patsubst %,tests/documents/%.sh,install package format dependencies layers pages editors features words) \
  tests/modules/programs/program_names.sh

check-asan: ## the quick tests under AddressSanitizer and UBSan
	$(Q)$(MAKE) --no-print-directory check CONFIG=asan TEST_SCRIPTS='$(filter-out $(SAME_SCRIPTS),$(TEST_SCRIPTS))'

check-valgrind: all tests-build ## the unit tests under valgrind
	$(Q)$(RUN_TESTS) --under 'valgrind -q --error-exitcode=9 --leak-check=full' $(filter $(D)/tests/unit/%,$(TEST_PROGRAMS))

coverage: ## lines that the quick tests execute, by layer (minutes; wanted by scripts/mutants)
	$(Q)$(MAKE) --no-print-directory tests-build CONFIG=coverage
	$(Q)HOOKE_DATA='$(HOOKE_DATA)' HOOKE_NIST='$(HOOKE_NIST)' scripts/coverage build/coverage \
	  $(patsubst $(D)/%,build/coverage/%,$(TEST_PROGRAMS)) $(TEST_SCRIPTS)

stories: ## lines that no story (tests/stories) and no failure test executes, by layer
	$(Q)$(MAKE) --no-print-directory $(patsubst $(D)/%,build/coverage/%,$(STORY_PROGRAMS)) build/coverage/hooke CONFIG=coverage
	$(Q)scripts/coverage --stories build/coverage $(patsubst $(D)/%,build/coverage/%,$(STORY_PROGRAMS)) \
	  $(filter tests/faults/%,$(TEST_SCRIPTS))

bench: all ## speed as ratios, measured in one run (never a test); BENCH=adaptive: that topic only
	$(Q)CC='$(CC)' FLAGS='$(CFLAGS)' LIBS='$(LIBS)' BUILD='$(TOP)' BENCH='$(BENCH)' scripts/bench

fresh: ## both commands of the README in minimal Debian roots made for that (needs root)
	$(Q)scripts/fresh

fuzz: ## run each fuzz target for FUZZ_SECONDS (default 60)
	$(Q)scripts/fuzz $(or $(FUZZ_SECONDS),60) $(FUZZERS)

house: all ## the sizes of the house: folders, files, functions, tags, words
	$(Q)scripts/house

lint: ## clang-tidy and cppcheck, of what changed
	$(Q)scripts/lint

# Flags that a compiler needs for all files at once.
lint-flags:
	@echo -I$(D) $(OPTIONAL_CPPFLAGS) $(LINE_CFLAGS) $(GSL_CFLAGS)

format: ## clang-format in place
	$(Q)clang-format -i $$(git ls-files '*.c' '*.h')

reference: all ## rewrite the generated parts of the README
	$(Q)scripts/reference readme $(TOP)/hooke

screens-update: all ## rewrite the expected screens from what the program draws now
	$(Q)scripts/screens update

LIBDIR ?= $(PREFIX)/lib
MANUAL  = $(DESTDIR)$(PREFIX)/share/man
SHARED  = $(DESTDIR)$(PREFIX)/share/hooke
COMPLETION = $(DESTDIR)$(PREFIX)/share/bash-completion/completions/hooke
VIM_FILES = $(DESTDIR)$(PREFIX)/share/vim/vimfiles
NANO    = $(DESTDIR)$(PREFIX)/share/nano/hooke.nanorc

install: all ## install program, library, headers, manual, examples and completion under PREFIX
	install -D -m 755 $(TOP)/hooke $(DESTDIR)$(PREFIX)/bin/hooke
	install -D -m 644 $(TOP)/libhooke.a $(DESTDIR)$(LIBDIR)/libhooke.a
	install -D -m 644 $(TOP)/libhooke.so.0 $(DESTDIR)$(LIBDIR)/libhooke.so.0
	ln -sf libhooke.so.0 $(DESTDIR)$(LIBDIR)/libhooke.so
	$(Q)printf '%s\n' 'prefix=$(PREFIX)' 'libdir=$(LIBDIR)' 'includedir=$${prefix}/include' '' \
	  'Name: hooke' 'Description: oscillators and numerical integration' 'Version: $(VERSION)' 'Requires.private: gsl' \
	  'Libs: -L$${libdir} -lhooke' 'Libs.private: $(SUNDIALS_LIBS) -lm -ldl -lpthread' 'Cflags: -I$${includedir}' \
	  >$(TOP)/hooke.pc && install -D -m 644 $(TOP)/hooke.pc $(DESTDIR)$(LIBDIR)/pkgconfig/hooke.pc
	cd include && for header in hooke/hooke.h hooke/api.h $(foreach l,$(LIBRARY_LAYERS),$(patsubst include/%,%,$(wildcard include/hooke/$l.h include/hooke/$l/*.h))); do \
	  install -D -m 644 $$header $(DESTDIR)$(PREFIX)/include/$$header || exit; done
	for page in $(PAGES); do install -D -m 644 $$page $(MANUAL)/man$${page##*.}/$${page##*/} || exit; done
	install -D -m 644 $(TOP)/pages/hooke.bash $(COMPLETION)
	install -D -m 644 $(TOP)/pages/hooke.vim $(VIM_FILES)/syntax/hooke.vim
	install -d $(VIM_FILES)/ftdetect && echo 'autocmd BufNewFile,BufRead *.hk setfiletype hooke' >$(VIM_FILES)/ftdetect/hooke.vim && \
	  chmod 644 $(VIM_FILES)/ftdetect/hooke.vim
	install -D -m 644 $(TOP)/pages/hooke.nano $(NANO)
	for example in $(EXAMPLES); do install -D -m $$([ -x $$example ] && echo 755 || echo 644) $$example $(SHARED)/$$example || exit; done
	scripts/make-recordings $(SHARED)/examples/lab && chmod 644 $(SHARED)/examples/lab/*.txt

uninstall: ## remove what install put there
	rm -f $(DESTDIR)$(PREFIX)/bin/hooke $(addprefix $(DESTDIR)$(LIBDIR)/,libhooke.a libhooke.so libhooke.so.0 pkgconfig/hooke.pc) $(COMPLETION) \
	  $(VIM_FILES)/syntax/hooke.vim $(VIM_FILES)/ftdetect/hooke.vim $(NANO)
	rm -f $(foreach page,$(notdir $(PAGES)),$(MANUAL)/man$(subst .,,$(suffix $(page)))/$(page))
	rm -rf $(DESTDIR)$(PREFIX)/include/hooke $(SHARED)

dist: ## the source of HEAD as build/hooke-VERSION.tar.gz, the same bytes each time
	@mkdir -p build
	$(Q)git -c tar.umask=0022 -c core.autocrlf=false -c core.attributesFile=/dev/null archive --format=tar --prefix=hooke-$(VERSION)/ -o build/hooke-$(VERSION).tar HEAD
	$(Q)gzip -9nf build/hooke-$(VERSION).tar

clean: ## remove build/
	rm -rf build

help: ## this list
	@awk -F':.*## ' '/^[a-z-]+:.*## /{printf "  %-16s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

.PHONY: all static texts dist optional tests-build check check-optional check-all check-asan check-valgrind coverage stories bench fresh fuzz house lint lint-flags format reference screens-update install uninstall clean help
.SECONDARY:

-include $(LIBRARY_OBJECTS:.o=.d) $(PROGRAM_OBJECTS:.o=.d) $(patsubst %.o,%.d,$(call object,$(TEST_SOURCES) $(ALONE)))

# All commands of the project; `make help` lists them.

# A variable that no command knows is a mistake, such as threads=2 or KERNELS=fluid.
variables := KERNEL FORM SCENE THREADS VARIANT FRAMES OUT RESUME FORCE QUICK FULL SOME SHARD SECONDS TARGET STEPS WIDTH \
  FIGURE FAILED ONLY ADD ISA BUILD CXX FLAGS LIBS PYTHON
# Words of a value, such as those of FLAGS, stand beside the names; they begin with a dash.
given := $(foreach word,$(filter-out -%,$(MAKEOVERRIDES)),$(if $(findstring =,$(word)),$(firstword $(subst =, ,$(word)))))
$(foreach name,$(filter-out $(variables),$(given)),$(error unknown variable $(name), expected one of: $(variables)))

# Every command uses all cores to build. make -j1 does not.
ifeq ($(MAKELEVEL),0)
MAKEFLAGS += -j$(shell nproc)
endif
MAKEFLAGS += --no-builtin-rules --no-print-directory

# Several commands, such as make deps verify, run one after another.
ifneq ($(word 2,$(MAKECMDGOALS)),)
.NOTPARALLEL:
.PHONY: $(MAKECMDGOALS)
$(MAKECMDGOALS):
	@$(MAKE) $@
else

# The instruction set of the lanes: by default the best of this machine.
ISA ?= $(shell grep -qw avx512vl /proc/cpuinfo && echo avx512 || (grep -qw avx2 /proc/cpuinfo && echo avx2) || echo portable)
isa_avx512   := -march=x86-64-v4 -DLOCKSTEP_ISA_AVX512
# Two registers a value: g++ copies such a pair by registers of 64 bits unless told otherwise. Clang has no such flag.
isa_avx2      = -march=x86-64-v3 $(if $(filter g++,$(CXX)),-mmove-max=256 -mstore-max=256) -DLOCKSTEP_ISA_AVX2
isa_portable := -DLOCKSTEP_ISA_PORTABLE
$(if $(isa_$(ISA)),,$(error ISA=$(ISA): expected avx512, avx2 or portable))

CXX   = g++
# -fno-math-errno: no code reads errno after math functions. Without the flag, sqrt prevents vectorization. Values do not
# change. Formulas for numbers and for lanes use | for both. Clang warns of | between truth values.
FLAGS = -std=c++20 -O3 $(isa_$(ISA)) -ffp-contract=off -fno-math-errno -fopenmp $(warnings)
warnings = -Wall -Wextra -Wno-bitwise-instead-of-logical
LIBS  = -lqhull_r
# Calls to OpenMP's runtime, and of flags, that the linker sends through verify/record_wraps.cpp.
WRAPPED = GOMP_parallel GOMP_parallel_sections GOMP_parallel_loop_nonmonotonic_dynamic GOMP_barrier \
  GOMP_loop_nonmonotonic_dynamic_start GOMP_loop_nonmonotonic_dynamic_next GOMP_loop_ull_nonmonotonic_dynamic_start \
  GOMP_loop_ull_nonmonotonic_dynamic_next GOMP_loop_end GOMP_loop_end_nowait GOMP_sections_next GOMP_sections_end_nowait \
  GOMP_single_start omp_get_thread_num omp_get_num_threads omp_get_max_threads omp_set_lock omp_unset_lock \
  lockstep_post lockstep_await
WRAPS = $(WRAPPED:%=-Wl,--wrap=%)
LINK  = $(CXX) $(FLAGS) $(WRAPS)
PYTHON = /usr/bin/python3
DEBS  = g++ make libcli11-dev libtomlplusplus-dev nlohmann-json3-dev libqhull-dev libeigen3-dev librandom123-dev libsuitesparse-dev libccd-dev libgtest-dev python3-matplotlib python3-vtk9 libjs-three xvfb xauth clang-14 libomp-14-dev libclang-rt-14-dev

# The folder of objects; each configuration has its own.
BUILD := build/$(ISA)

# Every file of serial/ is compiled twice: in float, and in double for the truth.
serial := $(shell find serial -name '*.cpp')
truth  := $(serial:%.cpp=$(BUILD)/%.double.o)
kernel := $(serial:%.cpp=$(BUILD)/%.float.o) $(truth) $(patsubst %.cpp,$(BUILD)/%.o,$(shell find openmp common -name '*.cpp'))
# The verifier's files of a domain are compiled as one: most of their time goes into the headers they share.
domains := $(patsubst %/,$(BUILD)/%/all.o,$(sort $(dir $(wildcard verify/*/*.cpp))))
verify := $(domains) $(patsubst %.cpp,$(BUILD)/%.o,$(wildcard verify/*.cpp))
tests  := $(patsubst %.cpp,$(BUILD)/%.o,$(wildcard tests/*_test.cpp))

# What no benchmark times is compiled at -O1: the truth, what reads and makes scenes and writes frames, the verifier
# except what measures, and the tests. Results have the same bits: notes/design.md.
of_scenes := toml scene scene_reader scene_values scene_generators generators make mass hulls stuffing faults \
  obj off ply stl polygons mesh_file facesim matrix_market vtk
readers := $(filter $(addprefix %/,$(addsuffix .o,$(of_scenes))),$(kernel))
measuring := $(patsubst %,$(BUILD)/verify/%.o,bench costs crew held_team record record_wraps samples team)
untimed := $(truth) $(readers) $(filter-out $(measuring),$(verify)) $(tests)
$(untimed): level = -O1
# The linker keeps the first copy of an inline function, so those at -O1 come last.
in_order = $(filter-out $(untimed),$^) $(filter $(untimed),$^)

.PHONY: all deps list verify test bench tables figures peers pictures gallery run view diff mutants tsan tsan-build sanitize determinism nightly portable fuzz endure extremes clean help
.DELETE_ON_ERROR:

all: build/lockstep  ## build everything, with the best ISA of this machine (ISA=avx512|avx2|portable)

deps:  ## install the Debian packages it needs (by sudo, if you are not root)
	@missing=$$(echo $$(for deb in $(DEBS); do dpkg-query -W -f '$${Status}' $$deb 2>/dev/null | grep -q ' ok installed' || echo $$deb; done)); \
	[ -n "$$missing" ] || { echo "all packages are installed"; exit 0; }; \
	say() { echo "make deps: as root, type: apt-get update && apt-get install $$missing" >&2; exit 2; }; \
	[ $$(id -u) = 0 ] && sudo= || { sudo=sudo; command -v sudo >/dev/null || say; echo "sudo apt-get install $$missing"; }; \
	$$sudo apt-get update -qq && DEBIAN_FRONTEND=noninteractive $$sudo apt-get install -y -qq $$missing || say

list: build/lockstep  ## print every kernel, its forms and their scenes
	build/lockstep list

verify: build/lockstep  ## compare every kernel with its serial twin (KERNEL= FORM= SCENE= THREADS=1,2,3 FULL=1 SHARD=1/2: a share, FAILED=1: print only failures); build/verify.json
	build/lockstep verify $(selection) $(if $(FULL),--full) $(if $(FAILED),--failed) $(shard) --json build/verify$(of_shard).json

test: $(BUILD)/unit_tests build/lockstep  ## unit, property and fault tests
	$(PYTHON) tests/notes_test.py
	$(PYTHON) tests/figures_test.py
	$(PYTHON) tests/frames_test.py
	$(PYTHON) tests/shards_test.py
	LOCKSTEP=build/lockstep $(PYTHON) -B tests/nightly_test.py
	$(PYTHON) tests/peers_test.py
	$(PYTHON) tests/tables_test.py
	$(PYTHON) tests/view_test.py
	xvfb-run -a $(PYTHON) tests/gallery_test.py
	LOCKSTEP=build/lockstep $(BUILD)/unit_tests --gtest_brief=1

bench: build/lockstep  ## time every kernel (KERNEL= FORM= SCENE= THREADS=all SHARD=1/2 QUICK=1: rough, RESUME=1: go on); build/bench.json
	build/lockstep bench $(selection) $(quick) $(resume) $(shard) --json build/bench$(of_shard).json

tables:  ## write the times of the last whole make bench into the notes
	$(PYTHON) -B notes/tables.py build/bench.json notes

figures: build/lockstep  ## redraw the papers' figures into build/figures/ (QUICK=1: rough, THREADS=all, RESUME=1: go on, FIGURE=scalability: one, FULL=1 FIGURE=production_modules: on its largest scene, SHARD=1/2: measure a share, draw nothing)
	$(PYTHON) notes/figures/measure.py build/lockstep $(drawn) $(if $(FIGURE),--figure '$(FIGURE)') \
	  $(if $(THREADS),--threads $(THREADS)) $(quick) $(if $(FULL),--full) $(resume) $(shard)
	@test ! -f build/peers.json || cp build/peers.json $(drawn)
	$(if $(SHARD),,$(PYTHON) notes/figures/draw.py $(drawn) $(FIGURE))
drawn = build/figures$(of_shard)$(if $(FIGURE),/$(FIGURE))

peers:  ## time other libraries on the same work, in turn with ours: Bullet, ODE, OpenVDB, hypre, Eigen, CHOLMOD, libccd; installs their packages (ONLY=bullet/pyramid_24, ADD=rows.json); build/peers.json
	@$(PYTHON) -B notes/peers/compare.py build/peers.json --programs $(BUILD)/peers \
	  --make 'env -u MAKEFLAGS -u MAKELEVEL make ISA=$(ISA) BUILD=$(BUILD)' $(if $(ONLY),--only '$(ONLY)') $(if $(ADD),--add '$(ADD)')

pictures: build/lockstep  ## render README's pictures, notes/pictures/*.png, from frames of our own
	for run in castle_hit:54 dam_break_100k:200 garment:150 mesh_96:1 falling_drop:20 glass_48:22 \
	  face_smile:12 face_frown:12 face_open_mouth:12 face_pucker:12 face_surprise:12 \
	  curtain_and_ball_5k:200 ball_5k:120 tube_5k:100 funnel:180; do \
	  build/lockstep run --scene $${run%:*} --frames $${run#*:} --out build/pictures/$${run%:*} --force || exit 1; done
	xvfb-run -a $(PYTHON) notes/pictures/render.py build/pictures notes/pictures

gallery: build/lockstep  ## make a page of stills and views of a dozen scenes, to open in a browser: build/gallery/index.html
	xvfb-run -a $(PYTHON) -B notes/views/gallery.py build/lockstep build/gallery

run: build/lockstep  ## simulate SCENE=flag_33, write frames for ParaView (OUT=build/frames/flag_33 FRAMES= VARIANT= FORM= THREADS= RESUME=1 FORCE=1)
	build/lockstep run --scene '$(or $(SCENE),$(error SCENE= says which scene to run))' \
	  --out "$(or $(OUT),build/frames/$$(basename '$(SCENE)' .toml))" $(resume) $(if $(FORCE),--force) \
	  $(if $(VARIANT),--variant $(VARIANT)) $(if $(FORM),--form $(FORM)) $(if $(THREADS),--threads $(THREADS)) \
	  $(if $(FRAMES),--frames $(FRAMES))

view: build/lockstep  ## put the serial and the openmp run of SCENE=flag_33 side by side into a page for a browser (FORM= FRAMES= THREADS=; VARIANT=: one run alone; OUT=build/views/flag_33.html)
	$(PYTHON) -B notes/views/view.py build/lockstep '$(or $(SCENE),$(error SCENE= says which scene to show))' \
	  "$(or $(OUT),build/views/$$(basename '$(SCENE)' .toml).html)" $(if $(VARIANT),--variant $(VARIANT)) \
	  $(if $(FORM),--form $(FORM)) $(if $(THREADS),--threads $(THREADS)) $(if $(FRAMES),--frames $(FRAMES))

diff: $(if $(FORM),build/lockstep)  ## show serial and openmp side by side: KERNEL=fluid/forces (FORM=cell_locks: its functions alone; WIDTH=)
	@test -f 'serial/$(KERNEL).cpp' -a -f 'openmp/$(KERNEL).cpp' || \
	  { echo "make diff: KERNEL='$(KERNEL)', expected one of: $(diff_kernels)" >&2; exit 2; }
	@width=$(or $(WIDTH),$$(stty size 2>/dev/null < /dev/tty | cut -d ' ' -f 2)); \
	  $(if $(FORM),$(PYTHON) -B verify/diff.py '$(KERNEL)' '$(FORM)' $${width:-243},diff --side-by-side --width=$${width:-243} --expand-tabs \
	  'serial/$(KERNEL).cpp' 'openmp/$(KERNEL).cpp' || true)
diff_kernels = $(patsubst serial/%.cpp,%,$(sort $(wildcard serial/*/*.cpp)))

mutants: build/lockstep  ## plant known mistakes one by one: verify or the sanitizer must catch each (KERNEL=, SOME=12 a day, SHARD=1/2)
	@$(PYTHON) -B tests/mutants/mutants.py --build $(BUILD) --objects='$(patsubst $(BUILD)/%,%,$(kernel) $(verify))' \
	  --compile='$(CXX) $(FLAGS)' --link='$(LINK)' --libs='$(LIBS)' \
	  --tsan-compile='clang++-14 $(tsan_flags)' --tsan-link='clang++-14 $(tsan_flags) $(WRAPS)' --tsan-make='env -u MAKEFLAGS -u MAKELEVEL make tsan-build' \
	  $(if $(KERNEL),--kernel $(KERNEL)) $(if $(SOME),--some $(SOME)) $(shard)

tsan_flags = -std=c++20 -O1 -g $(isa_portable) -ffp-contract=off -fno-math-errno -fno-builtin -fopenmp -fsanitize=thread $(warnings)
tsan-build:
	$(MAKE) build/tsan/lockstep build/tsan/racy BUILD=build/tsan ISA=portable CXX=clang++-14 FLAGS='$(tsan_flags)'
build/tsan/racy: $(kernel) $(BUILD)/tests/tsan/racy.o
	@echo "link $@" && $(CXX) $(FLAGS) $^ $(LIBS) -o $@

tsan: tsan-build  ## run every kernel under clang's thread sanitizer, and a racy twin that it must flag (KERNEL= QUICK=1 THREADS=2,4)
	QUICK=$(QUICK) verify/tsan.sh $(KERNEL)

sanitize:  ## run the tests under the address and undefined-behaviour sanitizers
	ASAN_OPTIONS=allocator_may_return_null=1 $(MAKE) test BUILD=build/sanitize-$(ISA) FLAGS='-std=c++20 -O1 -g1 $(isa_$(ISA)) -ffp-contract=off -fno-math-errno -fopenmp -fsanitize=address,undefined -fno-sanitize-recover=undefined'

determinism: build/lockstep  ## expect the same bits at 1, 2, 3, 4, 8 threads, with three values of OMP_SCHEDULE (SCENE=, and KERNEL=)
	rm -f build/determinism_*.json
	for schedule in static,1 dynamic,1 guided; do for scene in $(or $(SCENE),$$(build/lockstep list --json | $(PYTHON) -c $(determinism_scenes))); do \
	  OMP_SCHEDULE=$$schedule build/lockstep verify --threads 1,2,3,4,8 $(if $(KERNEL),--kernel $(KERNEL)) --scene $$scene \
	    --json build/determinism_$$scene.$$schedule.json || exit 1; done; done
	$(PYTHON) verify/same_bits.py build/determinism_*.json

determinism_scenes = 'import json, sys; print(*[scene for domain in json.load(sys.stdin)["domains"] for scene in domain["determinism"]])'

nightly: build/lockstep tsan-build  ## verify, determinism and tsan on 64 threads and large scenes, which takes hours (KERNEL= THREADS=)
	$(PYTHON) verify/nightly.py build/lockstep $(if $(KERNEL),--kernel '$(KERNEL)') $(if $(THREADS),--threads $(THREADS))

portable: build/lockstep  ## verify with AVX2, with portable lanes, and built by clang: expect the same bits as here
	build/lockstep verify --threads 1,2 --json build/portable_here.json
	$(call verify_elsewhere,avx2,avx2,g++)
	$(call verify_elsewhere,portable,portable,g++)
	$(call verify_elsewhere,clang,$(ISA),clang++-14)
	$(PYTHON) verify/same_bits.py --bitwise build/portable_*.json
# $(call verify_elsewhere,folder,lanes,compiler)
define verify_elsewhere
+$(MAKE) build/$(1)/lockstep BUILD=build/$(1) ISA=$(2) CXX=$(3)
build/$(1)/lockstep verify --threads 1,2 --json build/portable_$(1).json
endef

fuzz:  ## fuzz the readers of scenes, .fluid, meshes and Matrix Market under sanitizers, SECONDS=600 each, one a core (TARGET=rigid SHARD=1/2)
	$(MAKE) build/fuzz/loaders_fuzz BUILD=build/fuzz ISA=portable CXX=clang++-14 \
	  FLAGS='-std=c++20 -O1 -g1 $(isa_portable) -ffp-contract=off -fno-math-errno -fopenmp -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=undefined $(warnings)'
	SHARD='$(SHARD)' tests/fuzz/fuzz.sh $(or $(SECONDS),600) $(TARGET)
build/fuzz/loaders_fuzz: $(kernel) $(filter-out $(BUILD)/verify/main.o,$(verify)) $(BUILD)/tests/fuzz/loaders_fuzz.o
	@echo "link $@" && $(CXX) $(FLAGS) $(WRAPS) $^ $(LIBS) -o $@

endure: build/lockstep  ## run moving scenes for 20,000 steps: values stay valid, memory does not grow (SCENE=a.toml STEPS= SHARD=1/2)
	GLIBC_TUNABLES=glibc.malloc.hugetlb=1 build/lockstep endure $(if $(SCENE),--scene $(SCENE)) $(if $(STEPS),--steps $(STEPS)) $(shard) --json build/endure$(of_shard).json

extremes: build/lockstep  ## run the smallest and largest scenes; what exceeds memory must be refused before it allocates
	$(PYTHON) tests/extremes.py

clean:  ## remove what was built
	rm -rf build

help:  ## list these commands
	@sed -nE 's/^([a-z]+):.*## (.*)/  make \1\t\2/p' Makefile | expand -t 20

quick = $(if $(QUICK),--quick)
resume = $(if $(RESUME),--resume)
# A share of a command's cases; its report has a name of its own: build/verify.1of2.json.
shard = $(if $(SHARD),--shard '$(SHARD)')
of_shard = $(if $(SHARD),.$(subst /,of,$(SHARD)))
selection = $(if $(KERNEL),--kernel '$(KERNEL)') $(if $(FORM),--form '$(FORM)') $(if $(SCENE),--scene '$(SCENE)') $(if $(THREADS),--threads $(THREADS))

# build/lockstep links to the program that was built last. It changes with ISA.
ifneq ($(shell readlink build/lockstep),$(BUILD:build/%=%)/lockstep)
.PHONY: build/lockstep
endif
build/lockstep: $(BUILD)/lockstep
	@ln -sfn $(BUILD:build/%=%)/lockstep $@

# What takes longest begins first.
$(BUILD)/lockstep: $(domains) $(kernel) $(verify)
	@echo "link $@" && $(LINK) $(in_order) $(LIBS) -o $@

$(BUILD)/unit_tests: $(kernel) $(filter-out $(BUILD)/verify/main.o,$(verify)) $(tests)
	@echo "link $@" && $(LINK) $(in_order) $(LIBS) -lccd -lcholmod -lgtest_main -lgtest -pthread -o $@

# The programs of make peers. A peer's templates may fuse what ours may not; its objects come behind the kernels', whose
# copies of inline functions the linker keeps.
peer_flags_bullet  = -isystem /usr/include/bullet
peer_libs_bullet   = -lBulletDynamics -lBulletCollision -lLinearMath
peer_libs_ode      = -lode
peer_libs_openvdb  = -lopenvdb -ltbb
peer_libs_openvdb_tracking = $(peer_libs_openvdb)
peer_flags_hypre   = $(addprefix -isystem ,/usr/include/hypre $(patsubst -I%,%,$(filter -I%,$(shell mpicxx --showme:compile))))
peer_libs_hypre    = -lHYPRE $(shell mpicxx --showme:link)
peer_libs_cholmod  = -lcholmod
peer_libs_libccd   = -lccd
peer_shared := $(patsubst %,$(BUILD)/notes/peers/%.o,peer rigid pressure)
.SECONDARY: $(peer_shared) $(patsubst %.cpp,$(BUILD)/%.o,$(wildcard notes/peers/*.cpp))
$(BUILD)/notes/peers/%.o: private FLAGS += -ffp-contract=fast $(peer_flags_$(notdir $*))
$(BUILD)/peers/%: $(kernel) $(filter-out $(BUILD)/verify/main.o,$(verify)) $(peer_shared) $(BUILD)/notes/peers/%.o
	@mkdir -p $(@D) && echo "link $@" && $(LINK) $(in_order) $(LIBS) $(peer_libs_$*) -o $@

level = -O3
# g++ does not look for memory to free before it has 2 GB, which takes a tenth off the longest files.
without_collecting = $(if $(filter g++,$(CXX)),--param=ggc-min-heapsize=2000000)
compiler = @mkdir -p $(@D) && echo "compile $@" && $(CXX) $(FLAGS:-O3=$(level)) $(without_collecting) -I. -I$(BUILD)
compile = $(compiler) $(precompiled) -MMD -MP

# The headers that most files include are compiled once for each level of optimisation. For g++ alone: clang's builds
# show that every file includes what it uses, but for those of verify/DOMAIN, which are compiled as one.
precompiled = $(if $(filter g++,$(CXX)),-include $(BUILD)/precompiled$(level)/$(if $(filter tests/%,$<),tests,common)/standard.h)
made_by_gcc = $(if $(filter g++,$(CXX)),$(patsubst %,$(BUILD)/precompiled%/standard.h.gch,$(1)))
headers_made := $(call made_by_gcc,-O3/common -O1/common)
headers_of_tests := $(call made_by_gcc,-O1/tests)
.SECONDARY: $(headers_made) $(headers_of_tests)
$(tests): $(headers_of_tests)
$(BUILD)/precompiled-O3/%.gch: level = -O3
$(BUILD)/precompiled-O1/%.gch: level = -O1
precompile = $(compiler) -x c++-header -c $< -o $@ && cp $< $(@:.gch=)
$(BUILD)/precompiled-O1/%.gch: % Makefile | $(BUILD)/needs
	$(precompile)
$(BUILD)/precompiled-O3/%.gch: % Makefile | $(BUILD)/needs
	$(precompile)

$(BUILD)/%.float.o: %.cpp Makefile $(headers_made) | $(BUILD)/needs
	$(compile) -c $< -o $@
$(BUILD)/%.double.o: %.cpp Makefile $(headers_made) | $(BUILD)/needs
	$(compile) -DLOCKSTEP_REAL=double -c $< -o $@
$(BUILD)/%.o: %.cpp Makefile $(headers_made) | $(BUILD)/needs
	$(compile) -c $< -o $@

# Rewritten only when the files of the domain are others than before.
.SECONDARY: $(domains:.o=.cpp)
$(BUILD)/verify/%/all.cpp: FORCE
	@mkdir -p $(@D)
	@printf '#include "%s"\n' $(sort $(wildcard verify/$*/*.cpp)) > $@.new
	@cmp -s $@.new $@ && rm $@.new || mv $@.new $@
$(BUILD)/verify/%/all.o: $(BUILD)/verify/%/all.cpp Makefile $(headers_made) | $(BUILD)/needs
	$(compile) -c $< -o $@

# It runs on every x86-64 processor, to say that the rest does not.
$(BUILD)/verify/processor.o: precompiled =
$(BUILD)/verify/processor.o: verify/processor.cpp Makefile | $(BUILD)/needs
	$(compile) -march=x86-64 -c $< -o $@

# Made if the compiler and the headers of all packages are there.
$(tests): | $(BUILD)/needs_of_tests
$(BUILD)/needs: headers = CLI/CLI.hpp libcli11-dev toml++/toml.h libtomlplusplus-dev nlohmann/json.hpp nlohmann-json3-dev \
  libqhull_r/qhull_ra.h libqhull-dev eigen3/Eigen/Dense libeigen3-dev \
  Random123/philox.h librandom123-dev $(if $(findstring clang,$(CXX)),omp.h libomp-14-dev)
$(BUILD)/needs_of_tests: headers = gtest/gtest.h libgtest-dev ccd/ccd.h libccd-dev suitesparse/cholmod.h libsuitesparse-dev
$(BUILD)/needs $(BUILD)/needs_of_tests: Makefile
	@mkdir -p $(@D)
	@say() { echo "make:" $$* "missing; make deps installs all packages, README.md names them" >&2; exit 2; }; \
	command -v $(firstword $(CXX)) >/dev/null || say "the compiler $(CXX) is"; \
	missing=$$(printf '#if !__has_include(<%s>)\n%s\n#endif\n' $(headers) | $(CXX) -E -P -x c++ -) || exit 2; \
	[ -z "$$missing" ] || say $$missing
	@touch $@

# The commit and flags of the build, for reports. The file is rewritten only when they change.
$(BUILD)/verify/report.o: $(BUILD)/commit.h
$(BUILD)/commit.h: FORCE
	@mkdir -p $(@D)
	@printf '#define LOCKSTEP_COMMIT "%s"\n#define LOCKSTEP_FLAGS "%s"\n' "$$(git describe --always --dirty 2>/dev/null || echo unknown)" "$(FLAGS)" > $@.new
	@cmp -s $@.new $@ && rm $@.new || mv $@.new $@
FORCE:

-include $(shell find $(BUILD) -name '*.d' 2>/dev/null)

endif

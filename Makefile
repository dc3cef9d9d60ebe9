# Lamella on Debian 12: `make demo`, `make test`. See README.md.

BUILD_PACKAGES := g++ cmake ninja-build pkg-config libboost-dev libtbb-dev libopenexr-dev \
  libeigen3-dev librandom123-dev libtomlplusplus-dev libcli11-dev nlohmann-json3-dev libfmt-dev \
  libcairo2-dev fonts-dejavu-core libceres-dev libhwy-dev libssl-dev zlib1g-dev libpng-dev libjpeg62-turbo-dev libopenvdb-dev libembree-dev \
  pybind11-dev python3-dev python3-numpy
TEST_PACKAGES := libgtest-dev libgmock-dev librapidcheck-dev python3 python3-jsonschema \
  python3-pytest python3-xarray python3-matplotlib mypy python3-setuptools python3-wheel python3-pip \
  python3-venv \
  clang libclang-rt-14-dev chromium libopenmpi-dev openmpi-bin
# Node.js with npm, wherever it comes from.
TEST_PACKAGES += $(if $(shell command -v npm),,nodejs npm)
FORMAT_PACKAGES := clang clang-format clang-tidy

# The quick subset that `make test` also runs with sanitizers: readers of text and samplers, which
# need the room phase alone. `make asan` runs everything.
SANITIZED := StackFile|Random|HalfVector

# `make test CCACHE=ccache`: a compiler cache in the place of precompiled headers, which it cannot
# keep, and of groups of sources, which would be compiled anew for a change in one of them.
CCACHE :=
LAUNCHER := $(if $(CCACHE),-DCMAKE_CXX_COMPILER_LAUNCHER=$(CCACHE) -DLAMELLA_PCH=OFF -DLAMELLA_UNITY=OFF)

.PHONY: demo test bench speed account asan fuzz soak soak-collisions format tidy install-build-packages install-test-packages \
  install-format-packages release clean

demo: release
	./build/release/lamella compare spongecake_two_layer -o lamella-demo

# A minute of libFuzzer for each reader, with a seed of its own: what a test finds is found again.
test: export FUZZ_SEED := 1
test: install-test-packages release
	ctest --preset release
	cmake --preset asan $(LAUNCHER)
	cmake --build build/asan --target test_phase_stack test_phase_random test_phase_medium
	ctest --test-dir build/asan --output-on-failure -j2 -R '(^|/)($(SANITIZED))'
	$(FUZZ_READERS) 60

bench: release
	./build/release/lamella bench

# The figures of speed in the texts: measures everything, keeps it in compare/bench/release, and
# writes the marked blocks. For a machine that does nothing else, about an hour.
SPEED_ROUNDS := 3
SPEED_NOTE := on a machine that did nothing else
SPEED_SOLVER_SECONDS := 60
SPEED := ./build/release/lamella bench --rounds $(SPEED_ROUNDS) --quiet
RELEASE := compare/bench/release
speed: release
	mkdir -p $(RELEASE)
	$(SPEED) --isa scalar --only walks --json $(RELEASE)/scalar.json
	$(SPEED) --isa avx2 --only walks --only tilted --only models --json $(RELEASE)/avx2.json
	$(SPEED) --isa avx512 --solver-seconds $(SPEED_SOLVER_SECONDS) --json $(RELEASE)/avx512.json
	echo "$(SPEED_NOTE)" > $(RELEASE)/about.txt
	python3 compare/bench/speed_tables.py .

# Instructions of the compiled loops of walks.
account: release
	python3 tests/structure/loop_account.py build/release/lamella

asan: install-test-packages
	cmake --preset asan $(LAUNCHER)
	cmake --build --preset asan
	ctest --preset asan

# Longer than continuous integration can wait for: twenty times the walks.
soak: install-test-packages release
	LAMELLA_SOAK=1 ctest --preset release

# Walks against the solver with COLLISIONS collisions; goes on where it was ended.
COLLISIONS := 1e11
soak-collisions: release
	./build/release/lamella soak --collisions $(COLLISIONS)

# libFuzzer on every reader of what comes from outside, with sanitizers, for FUZZ_SECONDS each;
# corpora grow in build/fuzz/corpus from one call to the next. FUZZ: names of readers, if not all.
FUZZ_SECONDS := 600
FUZZ :=
fuzz: install-test-packages release
	$(FUZZ_READERS) $(FUZZ_SECONDS) $(FUZZ)
define FUZZ_READERS
	cmake --install build/release --prefix build/fuzz/installed >build/install.log
	cmake -S tests/fuzz/instrumented -B build/fuzz/build -G Ninja -DCMAKE_CXX_COMPILER=clang++ \
	  -DCMAKE_C_COMPILER=clang -DCMAKE_PREFIX_PATH=$(CURDIR)/build/fuzz/installed
	cmake --build build/fuzz/build
	tests/fuzz/fuzz.sh build/fuzz
endef

release: install-build-packages
	cmake --preset release $(LAUNCHER) -DLAMELLA_TESTS=$(if $(filter test soak,$(MAKECMDGOALS)),ON,OFF) \
	  -DLAMELLA_MPI=$(if $(filter test soak,$(MAKECMDGOALS)),ON,OFF) \
	  -DLAMELLA_TEST_TIMEOUT=$(if $(filter soak,$(MAKECMDGOALS)),14400,)
	cmake --build --preset release

format: install-format-packages
	git ls-files '*.cpp' '*.h' | xargs clang-format -i

# Precompiled headers of gcc are no input for it, so it has a configuration of its own.
tidy: install-build-packages install-format-packages
	cmake --preset tidy
	git ls-files '*.cpp' | grep -v '^tests/' | xargs -P 2 -n 4 clang-tidy --quiet -p build/tidy

install-build-packages: NEEDED := $(BUILD_PACKAGES)
install-test-packages: NEEDED := $(TEST_PACKAGES)
install-format-packages: NEEDED := $(FORMAT_PACKAGES)

# Installs what is missing; where that takes rights that are not there, prints the line to run.
install-build-packages install-test-packages install-format-packages:
	@missing=""; \
	for p in $(NEEDED); do \
	  dpkg-query -W -f='$${Status}' $$p 2>/dev/null | grep -q 'ok installed' || missing="$$missing $$p"; \
	done; \
	[ -z "$$missing" ] && exit 0; \
	if [ "$$(id -u)" = 0 ]; then as=""; \
	elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then as="sudo"; \
	else echo "Packages are missing. Run:  sudo apt-get install -y$$missing"; exit 1; fi; \
	$$as apt-get update && \
	$$as env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends $$missing

clean:
	rm -rf build

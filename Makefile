# Needs Rust (rustup), a C compiler, make and Python 3 with venv. What else a build or a
# test needs is brought into .tools/ by `tools` and `python` below, without root; `make clean`
# removes it again.

.SUFFIXES:
.NOTPARALLEL:
.PHONY: all build install demo manual deny msrv table1 wheel bench-report check fmt lint doc bench \
	tools python rust clean mutants test test-full test-lean test-mpi test-raw test-mitsuba test-materialx \
	test-colour test-metrics test-python test-fuzz beside-mitsuba example-mitsuba

CARGO = cargo
PYTHON = python3
VENV = $(CURDIR)/.tools/venv
# HDF5 is compiled from source by a crate that wants at least this cmake.
CMAKE_WANTED = 3.26
CMAKE_PACKAGE = cmake==4.4.4

# A link, so that cargo sees one path whichever cmake it leads to. A user's own choice is looked at
# first.
FOUND_CMAKE := $(or $(CMAKE),cmake)
override CMAKE := $(CURDIR)/.tools/cmake
export CMAKE

all: build

# What `bake --version` and `fit --version` show behind the version. Tests build without it, so that
# a commit rebuilds nothing there.
build install demo wheel: export AIRR_COMMIT := $(shell git rev-parse --short HEAD 2>/dev/null)

build: tools
	@test -x $(BIN)/fit || echo "building bake and fit: 4 to 8 minutes on 2 cores" >&2
	@$(CARGO) build --release --locked $(QUIET) -p bake -p fit -p reader

# What `build` made, copied to where cargo puts programs: nothing is compiled twice.
install: build
	@mkdir -p "$(PROGRAMS)"
	@for program in bake fit airr-reader; do \
		install -m 755 "$(BIN)/$$program" "$(PROGRAMS)/$$program" || exit 1; done
	@echo "installed bake, fit and airr-reader in $(PROGRAMS)" >&2
PROGRAMS = $(or $(CARGO_INSTALL_ROOT),$(CARGO_HOME),$(HOME)/.cargo)/bin
TARGET = $(or $(CARGO_TARGET_DIR),target)
BIN = $(TARGET)/release
# Progress goes to a terminal only; a pipe gets results.
QUIET = $$(test -t 1 || echo --quiet)

# ---- What a fresh machine lacks. Each step looks before it acts: no network once it is there, and
# an interrupted or moved set-up is done again.

tools:
	@test "$$($(CMAKE) --version 2>/dev/null | wc -l)" -gt 0 || { \
		mkdir -p .tools && rm -f $(CMAKE) && \
		if found=$$(command -v "$(FOUND_CMAKE)") && $(call cmake_is_new,"$$found"); then \
			echo "set-up: cmake found at $$found" >&2; \
		else \
			echo "set-up: no cmake >= $(CMAKE_WANTED) on PATH;" \
				"bringing $(CMAKE_PACKAGE) into .tools/venv" >&2; \
			$(venv) && $(pip) "$(CMAKE_PACKAGE)" && found="$(VENV)/bin/cmake"; \
		fi && ln -s "$$found" $(CMAKE); }

python: tests/requirements.txt
	@{ cmp -s tests/requirements.txt .tools/requirements.installed && \
		"$(VENV)/bin/python" -c '' 2>/dev/null; } || { \
		echo "set-up: bringing h5py, xarray and others into .tools/venv for the tests" >&2; \
		rm -f .tools/requirements.installed && $(venv) && $(pip) -r tests/requirements.txt && \
		cp tests/requirements.txt .tools/requirements.installed; }

# A rustup of the minimal profile lacks these two.
rust:
	@$(CARGO) fmt --version >/dev/null 2>&1 || rustup component add rustfmt
	@$(CARGO) clippy --version >/dev/null 2>&1 || rustup component add clippy

# $(1): a quoted path. The older of the two versions must be the wanted one.
cmake_is_new = test "$$(printf '%s\n' $(CMAKE_WANTED) \
	"$$($(1) --version 2>/dev/null | sed -n '1s/[^0-9]*\([0-9.]*\).*/\1/p')" | \
	sort -V | head -n 1)" = $(CMAKE_WANTED)
# A venv that was moved or cut short does not start pip. It is then made anew.
venv = { "$(VENV)/bin/python" -m pip --version >/dev/null 2>&1 || \
	$(PYTHON) -m venv --clear "$(VENV)" || { \
	echo "set-up: $(PYTHON) cannot make a virtual environment:" \
		"install it with venv (Debian: python3-venv)" >&2; \
	exit 1; }; }
pip = "$(VENV)/bin/python" -m pip install --quiet --disable-pip-version-check --only-binary :all:

# ---- Tests. What only those need who change the code stands in `check`: lints and documentation
# compile everything anew, which would be a quarter of `make test`.

test: tools python
	@echo "== tests" >&2
	@rm -f "$(SKIPPED)"
	@AIRR_SKIPPED="$(SKIPPED)" AIRR_PYTHON="$(VENV)/bin/python" \
		$(CARGO) test --workspace --locked
	@sort "$(SKIPPED)" 2>/dev/null | uniq -c | sed 's/^ */skipped tests: /' || true
SKIPPED = $(abspath $(TARGET))/skipped

# Tests of whole programs by name. Without the dev-dependencies of all members (`cargo build`, `-p`)
# everything would be compiled anew.
WHOLE = AIRR_PYTHON="$(VENV)/bin/python" $(CARGO) test --workspace --bins --test all --locked -- \
	--ignored --nocapture

FIT = -p fit -p edges -p estimator -p lab -p pictures

# The long parts that need nothing more than `test` does: `.ci/run` runs one of them after it.
PARTS = test-statistics test-cameras test-slowest test-pages test-package test-kills
.PHONY: $(PARTS) parts
parts:
	@echo $(PARTS)

# What takes minutes or wants more than a fresh machine has. Each is one command.
test-full: check test $(PARTS) test-lean test-mpi test-raw test-mitsuba test-materialx test-colour test-metrics \
	test-python test-fuzz

# With midair, whose macros want other features: nothing is compiled anew.
test-statistics: rust tools
	@echo "== stated errors over hundreds of drawn campaigns, and other long tests of fit" >&2
	@$(CARGO) test $(FIT) -p midair --lib --locked -- --ignored \
		--skip $(CAMERAS) $(addprefix --skip ,$(SLOWEST))

test-cameras: rust tools
	@echo "== campaigns of what cameras and sheets have beside the model" >&2
	@$(CARGO) test $(FIT) -p midair --lib --locked -- --ignored $(CAMERAS) \
		$(addprefix --skip ,$(SLOWEST))
CAMERAS = tests::camera::

test-slowest: rust tools python
	@echo "== the slowest statistics of fit, waves and programs of rays, uneven cubes" >&2
	@$(CARGO) test --workspace --lib --locked -- --ignored $(SLOWEST)
	@$(WHOLE) deviations:: wave:: one_wrong_angle
SLOWEST = statistics_near_full_scale statistics_of_uneven_light statistics_of_bounds \
	statistics_of_correlated_noise statistics_of_predictions statistics_of_mtf10_in_noise \
	traced_photographs_give_their_corner_size programs_record_what_single_rays_do \
	waves_are_those_of_a_pupil_on_a_raster errors_fall_as_theory_says grazing_incidence_along_the_rows_of_a_lattice \
	between_chosen_directions_polygons_keep_the_tolerance a_jump_is_said \
	beams_are_the_mean_of_plain_rays a_mean_over_azimuths_is_that_of_many_azimuths

# Every command of the pages and of the help, and what the pages show of it; pages in a browser.
test-pages: rust tools python
	@echo "== commands of the pages and of the help, and pages in a browser" >&2
	@$(WHOLE) pages:: help:: explore::

# A hundred kills of every command that writes, at random times; hostile files, broken streams, and
# the largest files that are read.
test-kills: rust tools python
	@echo "== kills, hostile files and files at the limits" >&2
	@$(WHOLE) kills:: hostile:: caps:: streams:: resume::

test-mpi: rust tools
	@command -v mpirun >/dev/null || { \
		echo "test-mpi: no mpirun: install Open MPI or MPICH" \
			"(Debian: libopenmpi-dev openmpi-bin libclang-dev)" >&2; exit 1; }
	@echo "== ranks of MPI" >&2
	@$(CARGO) clippy --workspace --features bake/mpi --all-targets --locked -- -D warnings
	@$(CARGO) test --workspace --features bake/mpi --test mpi --locked
	@$(CARGO) test -p bake --features mpi --lib --locked -- ranks

# The lean fitter, built from nothing: crates, seconds and megabytes,
# then its verbs.
test-lean: rust tools
	@echo "== the lean fitter" >&2
	@$(CARGO) test --workspace --test all --locked -- lean --include-ignored --nocapture

# The optional feature of camera raw, which brings a crate under another licence.
test-raw: rust tools
	@echo "== camera raw" >&2
	@$(CARGO) clippy -p fit -p lab --features fit/raw,lab/raw --all-targets --locked -- -D warnings
	@$(CARGO) test -p edges -p lab --features lab/raw --lib --locked -- raw:: photographs::

# A minute of random files for each reader of files; hours are in CONTRIBUTING.md. libhdf5 asks for
# as much memory as a damaged file says. In `airr-reader` a limit refuses that; here it is allowed.
# Files that are found go to target/fuzz, so that the kept corpus stays small.
test-fuzz: rust tools
	@$(CARGO) +nightly fuzz --version >/dev/null 2>&1 || { \
		echo "test-fuzz: needs rustup toolchain install nightly and cargo install cargo-fuzz" >&2; \
		exit 1; }
	@cd fuzz && for target in obj gltf stl ply table photograph toml result polygons view; do \
		echo "== fuzz $$target" >&2; mkdir -p "$(CURDIR)/target/fuzz/$$target"; \
		ASAN_OPTIONS=detect_odr_violation=0:allocator_may_return_null=1 $(CARGO) +nightly fuzz run \
			$$target "$(CURDIR)/target/fuzz/$$target" corpus/$$target -- \
			-max_total_time=60 -timeout=30 -rss_limit_mb=1500 \
			$$(test $$target = table && echo -malloc_limit_mb=2147483647 -rss_limit_mb=6000) || \
			exit 1; done

# MITSUBA_FIT: a script that does the published loop in Mitsuba (tests/beside_mitsuba.py says what
# it takes), optional; MITSUBA_PYTHON: an interpreter with mitsuba, h5py and the wheel; ROUNDS: how often both are
# timed, in turns.
test-mitsuba: demo
	@cd python/tests && $(or $(MITSUBA_PYTHON),$(PYTHON)) -m unittest test_mitsuba \
		test_photographs test_variants
	@test -n "$(MITSUBA_FIT)" || { \
		echo "test-mitsuba: MITSUBA_FIT names no script of the published loop: not compared" >&2; }
	@test -z "$(MITSUBA_FIT)" || $(MAKE) --no-print-directory beside-mitsuba
# Draws doc/desk.png and doc/stage.png, and fits a sheet by derivatives of the renderer; needs pillow.
example-mitsuba:
	@$(or $(MITSUBA_PYTHON),$(PYTHON)) doc/scenes.py
	@$(or $(MITSUBA_PYTHON),$(PYTHON)) doc/adam.py
beside-mitsuba:
	@$(or $(MITSUBA_PYTHON),$(PYTHON)) tests/beside_mitsuba.py --peer "$(MITSUBA_FIT)" \
		--rounds $(or $(ROUNDS),1)
	@$(BIN)/fit render $(MITSUBA_SCENE) -o demo/aerial.exr
	@$(or $(MITSUBA_PYTHON),$(PYTHON)) fit/doc/mitsuba_edge.py $(MITSUBA_SCENE) \
		-o demo/mitsuba.exr --compare demo/aerial.exr
MITSUBA_SCENE = --source $(CAMPAIGN)/source.exr --params demo/result.json --table demo/pair.h5 \
	--distance 300 --incidence 20

# The exported materials in the MaterialX library.
test-materialx: demo
	@$(venv) && $(pip) "materialx==1.39.5"
	@"$(VENV)/bin/python" tests/in_materialx.py $(BIN)/fit demo/result.json demo/pair.h5

# Named lamps against those of the package colour-science.
test-colour: demo
	@$(venv) && $(pip) "colour-science==0.4.7"
	@"$(VENV)/bin/python" -W ignore tests/in_colour.py $(BIN)/fit demo/pair.h5

# Pictures compared, with LPIPS by seeded weights, in an environment of their own: torch is large.
test-metrics: build wheel
	@$(call metrics,torch torchvision lpips)
	@cd python/tests && $(CURDIR)/.tools/metrics/bin/python -m unittest test_evaluate test_compare
	@.tools/metrics/bin/python tests/table1.py $(BIN) .tools/metrics/table1 --seeded-lpips
# $(1): further packages.
metrics = { test -x .tools/metrics/bin/python || $(PYTHON) -m venv .tools/metrics; } && \
	.tools/metrics/bin/python -m pip install --quiet --disable-pip-version-check --upgrade \
		"$$(ls $(CURDIR)/dist/midair-*.whl)[evaluate]" $(1)

# ---- The Python package: a wheel with the module and the programs, which `pip install` puts where
# there is neither Rust nor HDF5.

# The module takes what `build` compiled and links it once more. The tag of the file follows from the
# C library that the programs need (python/build_backend.py).
wheel: build
	@rm -rf dist && $(call wheel_into,dist)

# $(1): a folder.
wheel_into = $(venv) && $(pip) "maturin>=1.16,<2" && PATH="$(VENV)/bin:$$PATH" \
	"$(VENV)/bin/python" -m pip wheel --quiet --disable-pip-version-check --no-deps \
	--no-build-isolation --wheel-dir $(1) .

# The tests of the package with the optimisation of tests, in the environment of the tests.
test-package: tools python
	@echo "== the Python package" >&2
	@rm -rf .tools/dist && AIRR_PROFILE=dev && export AIRR_PROFILE && $(call wheel_into,.tools/dist)
	@$(pip) --force-reinstall --no-deps .tools/dist/midair-*.whl
	@cd python/tests && "$(VENV)/bin/python" -m unittest $(PACKAGE_TESTS)
PACKAGE_TESTS = test_programs test_pickles test_tables test_arrays test_evaluate test_compare \
	test_process test_signatures test_pages test_variants

# The wheel as a user installs it, in a new environment and with an empty PATH: all tests of the
# package, its examples, its programs and its notebooks.
test-python: wheel
	@echo "== the wheel, in a new environment and with an empty PATH" >&2
	@rm -rf .tools/wheel && $(PYTHON) -m venv .tools/wheel
	@.tools/wheel/bin/pip install --quiet --disable-pip-version-check dist/midair-*.whl \
		-r tests/requirements.txt -r python/notebooks/requirements.txt
	@cd python/tests && env -i PATH= $(CURDIR)/.tools/wheel/bin/python -m unittest \
		$(PACKAGE_TESTS) test_notebooks
	@cd .tools/wheel && env -i PATH= bin/python -W ignore $(CURDIR)/python/tests/examples.py \
		$(CURDIR)/$(CAMPAIGN)/captures.toml . >/dev/null
	@cd .tools/wheel && env -i bin/bake --help >/dev/null && \
		env -i bin/bake design triangular-pair -o pair.obj && \
		env -i bin/bake trace pair.obj -o pair.h5 --refractive-index 1.49 --incidence 0:45:5 \
			--azimuth 30 && \
		env -i bin/fit estimate $(CURDIR)/$(CAMPAIGN)/captures.toml --table pair.h5 -o result.json

# clippy and doc share the metadata of the dependencies.
check: fmt lint doc

fmt: rust
	@echo "== format" >&2
	@$(CARGO) fmt --all --check

lint: rust tools
	@echo "== lints" >&2
	@$(CARGO) clippy --workspace --all-targets --locked -- -D warnings
	@$(CARGO) clippy -p fit --no-default-features --locked -- -D warnings

doc: tools
	@echo "== documentation" >&2
	@RUSTDOCFLAGS="-D warnings" $(CARGO) doc --workspace --no-deps --locked

# Licences, sources and bans of dependencies (deny.toml), where cargo-deny is installed: cargo
# install cargo-deny.
deny: tools
	@$(CARGO) deny --version >/dev/null 2>&1 || { \
		echo "deny: cargo-deny is not installed: cargo install --locked cargo-deny" >&2; exit 1; }
	@$(CARGO) deny --workspace --locked check bans licenses sources

# The oldest Rust that Cargo.toml promises: clippy (in `lint`) knows what of the standard library is
# younger, this compiles with it.
msrv: tools
	@rustup run $(MSRV) cargo --version >/dev/null 2>&1 || { \
		echo "msrv: Rust $(MSRV) is not installed: rustup toolchain install $(MSRV)" >&2; exit 1; }
	@rustup run $(MSRV) cargo check --workspace --all-targets --locked
MSRV := $(shell sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)

# Manual pages of both programs, and completions of a shell: make manual SHELL_NAME=zsh
manual: build
	@$(BIN)/bake manual target/manual && $(BIN)/fit manual target/manual
	@for program in bake fit; do $(BIN)/$$program completions $(or $(SHELL_NAME),bash) \
		> target/manual/$$program.$(or $(SHELL_NAME),bash); done

# Random small changes to the code that computes (.cargo/mutants.toml), each tried by its crate's own tests. SHARD: which sample is taken, 0 to 2799; 4 changes each.
mutants: tools
	@$(CARGO) mutants --version >/dev/null 2>&1 && $(CARGO) nextest --version >/dev/null 2>&1 || { \
		echo "mutants: needs cargo install --locked cargo-mutants cargo-nextest" >&2; exit 1; }
	@CARGO_TARGET_DIR="$(CURDIR)/target/mutants" $(CARGO) mutants --shard $(or $(SHARD),0)/2800 \
		--sharding round-robin --baseline skip --timeout 240 --output target

# The headline figures of this machine, which should be idle. PAGE: where they are written.
bench-report: build python
	@"$(VENV)/bin/python" tests/bench_report.py $(BIN) -o $(or $(PAGE),doc/measured.md)

bench: tools
	@if ls */benches/*.rs >/dev/null 2>&1; then $(CARGO) bench --workspace --locked --bench '*'; \
		else echo "bench: no package has a benches/ folder yet"; fi

# ---- The published comparison: models fitted to photographs of a physical truth, images rendered
# and scored. LPIPS is scored where torch, lpips and its weights are in .tools/metrics.

table1: build wheel
	@$(call metrics)
	@.tools/metrics/bin/python tests/table1.py $(BIN) fit/doc/table1

# ---- From a mesh and photographs to a, c and mu.

CAMPAIGN = tests/captures/public_per_angle

demo: build
	@mkdir -p demo
	@echo "demo: a cell, its ray-shift table, and the estimate from" \
		"$(words $(wildcard $(CAMPAIGN)/aerial_*.exr)) photographs" >&2
	@$(BIN)/bake design triangular-pair -o demo/pair.obj
	@$(BIN)/bake trace demo/pair.obj -o demo/pair.h5 --refractive-index 1.49 --incidence 0:45:5 \
		--azimuth 30
	@$(BIN)/bake inspect demo/pair.h5 --plot demo/shift.svg
	@$(BIN)/fit estimate $(CAMPAIGN)/captures.toml --table demo/pair.h5 \
		--truth $(CAMPAIGN)/truth.json \
		-o demo/result.json --plot demo/mtf.svg --report demo/report.html
	@$(BIN)/fit explore demo/result.json --table demo/pair.h5 -o demo/explore.html
	@echo
	@echo "demo/explore.html a sign and its mid-air image, with sliders: open this first"
	@echo "demo/report.html  the estimate on one page"
	@echo "demo/pair.obj     the mesh of one cell"
	@echo "demo/pair.h5      its ray-shift table"
	@echo "demo/shift.svg    the histograms of the ray shift"
	@echo "demo/result.json  a, c and mu with standard errors and covariance"
	@echo "demo/mtf.svg      measured and modelled MTF of every photograph"

clean:
	$(CARGO) clean
	rm -rf .tools demo dist

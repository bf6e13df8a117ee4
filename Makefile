# make demo   the whole pipeline on an embedded synthetic recording, into out/demo
# make test   the test suite         make test-slow   its tests that take longer
# make lint   ruff, clang-format and mypy          make wheel   build and check the wheel
# make mutation   whether the tests notice small faults in MUTATED (hours; resumes)
# make fuzz   hostile files, manifests and command lines by the thousand (FUZZ_SECONDS of each kind)
# make sanitize   tests of compiled code under AddressSanitizer and UBSan
# make bench   performance beside other libraries, into docs/benchmarks.md and the README, in less
#              than half an hour; SUITE=blend: one suite, into the terminal (JSON=FILE)
# make docs   the documentation site, into build/site
# make release   what is released: sdist and wheels for glibc 2.28, into dist
# make web   the bundle of libraries that the pages in the browser hold, anew (needs npm)
# make kernels   generate the kernels from their definitions
# Each prepares what it needs by itself: environment, dependencies, compiled kernels.

PYTHON  ?= python3
VENV    := .venv
BIN     := $(VENV)/bin
ROOMS   := ga tracking fusion animation render replays
READY   := $(VENV)/.ready
WEB     := replays/web/modules
NATIVE  := CMakeLists.txt pyproject.toml constraints.txt $(wildcard ga/kernels/generated/c/* $(foreach kind,c cpp h,$(wildcard */native/*.$(kind) */*/native/*.$(kind) */*/native/generated/*.$(kind))))

# C and C++ that people write.
WRITTEN := $(foreach kind,c cpp h,$(wildcard */native/*.$(kind) */*/native/*.$(kind) */*/*/native/*.$(kind) docs/examples/*.$(kind) tests/bench/*/*.$(kind) tests/bench/*/*/*.$(kind)))

.PHONY: demo test test-slow bench mutation fuzz sanitize docs lint wheel release kernels web names system browser clean
.DEFAULT_GOAL := demo

demo: $(READY) system
	@echo "drawing a small recording, and everything run on it: about a minute on two processors"
	$(BIN)/motorcade demo --out out/demo

# Two workers on two processors: threads of linear algebra beside them would wait for each other.
test test-slow fuzz wheel: export OPENBLAS_NUM_THREADS := 1

test: $(READY) system
	$(BIN)/python -m pytest -q -n 2 --dist loadgroup -m "not slow"

test-slow: $(READY) browser
	$(BIN)/python -m pytest -q -n 2 --dist loadgroup -m slow

# Names modules or folders of one room; see tests/mutation/__main__.py.
MUTATED ?= $(wildcard ga/*.py) ga/algebra ga/codegen/passes ga/classical ga/script ga/versors
mutation: $(READY)
	$(BIN)/python -m tests.mutation $(MUTATED)

bench: $(READY)
	$(BIN)/python -m tests.bench $(SUITE) $(if $(JSON),--json $(JSON))

# Every input must end in an own error or a valid value, within bounds of time and memory. Each
# kind is fed for FUZZ_SECONDS.
FUZZ_SECONDS ?= 6
FUZZ_SEED ?= 1

fuzz: $(READY)
	$(BIN)/python -m tests.fuzz --seconds $(FUZZ_SECONDS) --seed $(FUZZ_SEED)

# Builds all modules apart from the environment's own, into build/sanitized.
sanitize: $(READY)
	$(BIN)/python -m tests.sanitized

lint: $(READY) names
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/clang-format --dry-run -Werror $(WRITTEN)
	MYPYPATH=build/names $(BIN)/mypy $(addprefix -p motorcade.,$(ROOMS)) -p tests.bench
	@if command -v npm >/dev/null; then $(MAKE) --no-print-directory build/web && cd build/web && \
	  npm run --silent lint && npm run --silent types && npm run --silent test; else echo "no npm here: no JavaScript is linted"; fi

# Strict: a broken link or anchor is an error. mkdocs finds the rooms by their names as mypy does.
docs: $(READY) names
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet

# Writes the kernels' C and NumPy code, and the C header of the filters, anew from their definitions;
# `make` then compiles it.
kernels: $(READY)
	$(BIN)/python -m motorcade.ga.codegen
	$(BIN)/python -m motorcade.fusion.smoothing.header
	$(BIN)/python -m motorcade.fusion.filter.model
	$(BIN)/python -m motorcade.fusion.sync.model

# three.js and uPlot as one module, from what package-lock.json names.
web: build/web
	cd build/web && npm run --silent vendor
	cp build/web/vendor.* build/web/VENDOR_LICENSES.txt $(WEB)/

# A copy to work in: what npm brings holds Python too, and belongs into no room.
.PHONY: build/web
build/web:
	@mkdir -p build/web && cp -r $(WEB)/. build/web
	cd build/web && npm ci --silent

wheel: $(READY)
	bash .ci/check_wheel

# PYTHONS="python3.11 python3.12" names those it is for; by default those of the two that are here.
release:
	bash .ci/release_wheels $(PYTHONS)

# The environment is complete when this stamp is newer than everything it was made from.
$(READY): $(NATIVE)
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "motorcade needs Python 3.11 or newer; say PYTHON=python3.x")'
	@echo "1 of 3: an environment in $(VENV) with pip and what builds (some 10 s)"
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install -q -c constraints.txt pip setuptools wheel scikit-build-core nanobind numpy
	@echo "2 of 3: packages of constraints.txt, named as they come (2.5 GB on the disk; minutes the first time)"
	@echo "3 of 3: after 'Building editable', C and C++ compiled: without a word, some minutes of a processor"
	@$(BIN)/python -m pip install -c constraints.txt --no-build-isolation --progress-bar off -e ".[dev]"
	@touch $@

# Headless OpenGL comes from the system's packages: installed where permitted, named where not.
system:
	@sh .ci/system_libraries

# The same, and a browser, in which tests open the pages.
browser:
	@sh .ci/system_libraries tests

# mypy and mkdocs find motorcade.<room> through these links, since the rooms lie at the top of the
# repository. The file makes it a whole package: a clone named motorcade would else be taken for a
# part of it, with its tests and builds.
names:
	@mkdir -p build/names/motorcade
	@echo "__version__: str" > build/names/motorcade/__init__.py
	@for room in $(ROOMS); do ln -sfn ../../../$$room build/names/motorcade/$$room; done

clean:
	rm -rf $(VENV) build dist out .mypy_cache .ruff_cache .pytest_cache

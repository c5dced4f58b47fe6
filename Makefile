# seatrial: `make demo` and `make test` set up what they need in .venv and run. `make help` lists all.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
CORE   := core/CMakeLists.txt core/bindings/CMakeLists.txt $(shell find core/include core/bindings -name "*.?pp")
PIP    := $(BIN)/python -m pip install --quiet --disable-pip-version-check
# tools are compiled where they are imported: half of the installation's CPU time
TOOLS  := $(PIP) --no-compile

# compiled modules are kept, whatever the environment says: else every worker and every `seatrial` compiles them again
export PYTHONDONTWRITEBYTECODE :=

# small matrices on few cores: more threads in BLAS only get in each other's way
PYTEST := OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest --dist worksteal --durations 40
# a process more than cores: system tests wait for other programs
MORE := $$(expr $$(nproc) + 1)

.PHONY: help demo test test-system test-all test-study lint wheels docs format stub lock bench clean

help: ## this list
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/make \1\t\2/p' $(MAKEFILE_LIST) | expand -t 20

demo: $(VENV)/.built ## identify, validate and report on the bundled recordings, into demo/
	$(BIN)/seatrial demo --out demo

test: $(VENV)/.built $(VENV)/.test ## unit tests, with the package alone; PYTEST_ARGS="tests/test_io.py -x" for a part
	$(PYTEST) --numprocesses auto -m unit $(PYTEST_ARGS)

test-system: $(VENV)/.built $(VENV)/.test ## tests with other programs (compilers, ROS, a browser, Octave, qemu), and long ones
	$(PYTEST) --numprocesses $(MORE) -m "system and not study" $(PYTEST_ARGS)

test-all: $(VENV)/.built $(VENV)/.test ## both in one run
	$(PYTEST) --numprocesses $(MORE) -m "not study" $(PYTEST_ARGS)

test-study: $(VENV)/.built $(VENV)/.test ## further seeds of tests' cases, which nothing runs by itself
	$(PYTEST) --numprocesses auto -m study $(PYTEST_ARGS)

lint: $(VENV)/.built $(VENV)/.test ## ruff, mypy --strict, clang-format, clang-tidy
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	clang-format --dry-run --Werror $$(git ls-files 'core/*.hpp' 'core/*.cpp' 'ros/*.hpp' 'ros/*.cpp' | grep -v third_party)
	$(BIN)/python tools/tidy.py

wheels: $(VENV)/.wheels ## wheels for Linux on x86-64 and aarch64, into dist/; needs python3.10, 3.11 and 3.12
	$(BIN)/python tools/wheels.py $(WHEELS_ARGS)

docs: $(VENV)/.built $(VENV)/.docs ## the site with the notebooks run, site/index.html; a link that leads nowhere is an error
	NO_MKDOCS_2_WARNING=1 OPENBLAS_NUM_THREADS=1 $(BIN)/mkdocs build --strict

format: $(VENV)/.test ## format Python and C++
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .
	clang-format -i $$(git ls-files 'core/*.hpp' 'core/*.cpp' 'ros/*.hpp' 'ros/*.cpp' | grep -v third_party)

bench: $(VENV)/.built $(VENV)/.test ## speed, as ratios within one run
	$(BIN)/python -m benchmarks.run
	$(BIN)/python -m benchmarks.startup
	$(BIN)/python -m benchmarks.estimators
	$(BIN)/python -m benchmarks.scaling

stub: $(VENV)/.built ## the type stub, after a change of the core's bindings
	$(BIN)/python -m nanobind.stubgen -q -m seatrial._core -o src/seatrial/_core.pyi

lock: $(VENV)/.test ## pin dependencies with hashes, after a change of them in pyproject.toml
	$(BIN)/python tools/lock.py

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || \
	  { echo "seatrial needs Python 3.10 or later; set PYTHON=/path/to/python3"; exit 1; }
	@$(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); \
	  echo "Python's venv is missing: apt install python3-venv, or set PYTHON=..."; exit 1; }

$(VENV)/.deps: requirements/base.txt | $(VENV)/bin/python
	$(PIP) --require-hashes -r requirements/base.txt
	@touch $@

$(VENV)/.test: requirements/test.txt | $(VENV)/.deps
	$(TOOLS) --require-hashes -r requirements/test.txt
	@touch $@

$(VENV)/.docs: requirements/docs.txt | $(VENV)/.deps
	$(TOOLS) --require-hashes -r requirements/docs.txt
	@touch $@

$(VENV)/.wheels: requirements/wheels.txt | $(VENV)/.deps
	$(TOOLS) --require-hashes -r requirements/wheels.txt
	@touch $@

$(VENV)/.built: $(VENV)/.deps pyproject.toml $(CORE)
	$(PIP) --no-deps --no-build-isolation --editable .
	@touch $@

clean: ## remove all that was built
	rm -rf $(VENV) build demo dist site .mypy_cache .ruff_cache .pytest_cache .hypothesis

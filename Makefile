# seatrial: `make demo` and `make test` set up what they need in .venv and run.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
CORE   := CMakeLists.txt $(wildcard core/include/seatrial/*/*.hpp core/bindings/*.?pp)
PIP    := $(BIN)/python -m pip install --quiet --disable-pip-version-check

.PHONY: demo test lint docs format stub lock bench clean

demo: $(VENV)/.built
	$(BIN)/seatrial demo --out demo

# small matrices on few cores: more threads in BLAS only get in each other's way
test: $(VENV)/.built $(VENV)/.test
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses auto --dist loadfile \
	  --no-loadscope-reorder $(PYTEST_ARGS)

lint: $(VENV)/.built $(VENV)/.test
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	clang-format --dry-run --Werror $$(git ls-files 'core/*.hpp' 'core/*.cpp' 'ros/*.hpp' 'ros/*.cpp' | grep -v third_party)
	cmake -S . -B build/tidy -DCMAKE_EXPORT_COMPILE_COMMANDS=ON -DCMAKE_BUILD_TYPE=Debug
	git ls-files 'core/tests/test_*.cpp' 'ros/common/tests/*.cpp' | \
	  xargs -n 1 -P $$(nproc) clang-tidy --quiet -p build/tidy

# the site, site/index.html; a link that leads nowhere is an error
docs: $(VENV)/.docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

format: $(VENV)/.test
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .
	clang-format -i $$(git ls-files 'core/*.hpp' 'core/*.cpp' 'ros/*.hpp' 'ros/*.cpp' | grep -v third_party)

bench: $(VENV)/.built $(VENV)/.test
	$(BIN)/python -m benchmarks.run
	$(BIN)/python -m benchmarks.estimators
	$(BIN)/python -m benchmarks.scaling

# after a change of the core's bindings
stub: $(VENV)/.built
	$(BIN)/python -m nanobind.stubgen -q -m seatrial._core -o src/seatrial/_core.pyi

# after a change of the dependencies in pyproject.toml
lock: $(VENV)/.test
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
	$(PIP) --require-hashes -r requirements/test.txt
	@touch $@

$(VENV)/.docs: requirements/docs.txt | $(VENV)/.deps
	$(PIP) --require-hashes -r requirements/docs.txt
	@touch $@

$(VENV)/.built: $(VENV)/.deps pyproject.toml $(CORE)
	$(PIP) --no-deps --no-build-isolation --editable .
	@touch $@

clean:
	rm -rf $(VENV) build demo site .mypy_cache .ruff_cache .pytest_cache .hypothesis

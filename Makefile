# `make help` lists the targets. Everything lands in .venv/, target/ and demo/.

SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
DEMO := demo
# What the development tools are installed with: avod brings torch, some gigabytes. WITHOUT_AVOD leaves both out.
EXTRAS = dev$(if $(WITHOUT_AVOD),,$(comma)avod)
comma := ,
DEVELOP = VIRTUAL_ENV=$(CURDIR)/$(VENV) $(BIN)/maturin develop --release --locked
# One line for a command: what it does, then how long it took. What it says goes to a file, and is shown if it fails.
quietly = printf '%s ... ' '$(1)'; $(2) > $(VENV)/build.log 2>&1 && echo "done in $$SECONDS s" \
	|| { code=$$?; echo "failed after $$SECONDS s"; cat $(VENV)/build.log >&2; exit $$code; }
# A process for each of up to four cores, each with one thread: threads of several would wait for each other.
PYTEST := OMP_NUM_THREADS=1 $(BIN)/pytest -n auto --maxprocesses 4 --dist loadfile --no-loadscope-reorder
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet

# One interpreter for maturin, clippy and the tests, so that the bindings are compiled once.
export PYO3_PYTHON := $(CURDIR)/$(BIN)/python
# The tests and the demo run what stands in this folder, not what another environment has on its path.
unexport PYTHONPATH
unexport PYTHONHOME

.PHONY: help check-rust check-python setup build build-dev wheel demo test test-core lint test-rust test-python test-fast emulator golden \
	fuzz faults readers bench bench-tables bench-peers bench-traffic bench-gpu gallery docs fmt clean
.NOTPARALLEL:

help: ## List the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-11s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

check-rust:
	@command -v cargo > /dev/null && command -v rustc > /dev/null \
		|| { echo "cadet needs Rust 1.89 or newer: install it from https://rustup.rs" >&2; exit 1; }
	@rustc --version | awk '{ split($$2, v, "."); exit !(v[1] > 1 || (v[1] == 1 && v[2] + 0 >= 89)) }' \
		|| { echo "cadet needs Rust 1.89 or newer, found $$(rustc --version): run 'rustup update'" >&2; exit 1; }
	@command -v cc > /dev/null || command -v gcc > /dev/null || command -v clang > /dev/null \
		|| { echo "Rust needs a C linker: install gcc or clang (Debian: apt install gcc libc6-dev)" >&2; exit 1; }

check-python:
	@command -v $(PYTHON) > /dev/null \
		|| { echo "cadet needs Python 3.10 or newer: '$(PYTHON)' was not found (make PYTHON=/path/to/python3 names another)" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' \
		|| { echo "cadet needs Python 3.10 or newer, found $$($(PYTHON) --version) (make PYTHON=/path/to/python3 names another)" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2> /dev/null \
		|| { echo "$(PYTHON) cannot make virtual environments: install its venv package (Debian: apt install python3-venv)" >&2; exit 1; }

$(BIN)/python: | check-python
	@echo "Making $(VENV)"
	@$(PYTHON) -m venv $(VENV)

$(BIN)/maturin: | $(BIN)/python
	@echo "Installing maturin into $(VENV)"
	@$(PIP) install 'maturin>=1.9.4,<2'

$(BIN)/ruff: | $(BIN)/python
	@$(PIP) install 'ruff>=0.6'

setup: check-rust $(BIN)/maturin ## Make .venv with the build tool

build: setup ## Build the release extension and install it with its dependencies into .venv
	@$(call quietly,Building the Rust core (the first time takes three to seven minutes),$(DEVELOP))

build-dev: setup ## The same with the tools for tests and lints
	@$(call quietly,Building the Rust core and installing the development tools (the first time takes some minutes),\
		$(DEVELOP) --extras $(EXTRAS))

wheel: setup ## Build a wheel for this machine into dist/, which pip installs where there is no Rust
	@rm -rf dist
	@$(call quietly,Building a wheel (the first time takes three to seven minutes),$(BIN)/maturin build --release --locked --out dist)
	@du -h dist/*.whl

demo: build ## Write 40 samples and a picture of them to demo/
	@rm -rf $(addprefix $(DEMO)/,training testing ImageSets manifest.json recipe.toml croissant.json run.json overview.png)
	@$(BIN)/cadet-gen $(DEMO) -n 40 --seed 0
	@$(BIN)/cadet view $(DEMO) -o $(DEMO)/overview.png
	@echo "Look at $(DEMO)/overview.png; $(DEMO)/training is the KITTI folder, and 'make help' lists what else there is."

test: lint test-rust test-python ## Check everything, the detector too: formats, lints, types, tests (what CI runs)

test-core: WITHOUT_AVOD := yes
test-core: lint test-rust test-python ## The same without avod, and so without torch
	@echo "avod was left out: 'make test' checks its types and runs its tests too"

lint: build-dev ## Check formats, clippy, docs, ruff, types, and who imports whom
	cargo fmt --all --check
	cargo clippy --release --locked --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS='-D warnings' cargo doc --release --locked --quiet --workspace --no-deps --document-private-items
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/lint-imports --no-cache
	$(BIN)/mypy $(if $(WITHOUT_AVOD),--exclude '/avod/|tools/|support/detector/')
	MYPYPATH=python $(BIN)/stubtest cadet._cadet --mypy-config-file pyproject.toml

test-rust: check-rust
	cargo test --release --locked

test-python: build-dev emulator
	$(PYTEST) --durations=25 $(if $(WITHOUT_AVOD),--ignore tests/avod --ignore tests/tools)

test-fast: build-dev ## Run the Python tests that matter while working: minutes less than all of them
	$(PYTEST) -m 'not slow'

# The golden frames are made on other processors too. A developer without the emulator sees a skipped test, CI may not.
emulator:
	@case "$${CI:-}" in '' | 0 | false) exit 0 ;; esac; \
		if command -v qemu-x86_64 > /dev/null; then exit 0; fi; \
		as_root=; if [ "$$(id -u)" -ne 0 ]; then as_root=sudo; fi; \
		echo "Installing qemu's user mode"; \
		$$as_root apt-get -qq update && $$as_root env DEBIAN_FRONTEND=noninteractive \
			apt-get -qq install -y --no-install-recommends qemu-user > /dev/null

fuzz: build-dev ## Feed every reader with 100,000 damaged files, half an hour on one core (COUNT=1000 for fewer)
	PYTHONPATH=tests/support $(BIN)/python -m fuzz $(or $(COUNT),100000)

faults: build-dev ## Generate under 1,000 schedules of faults, a quarter of an hour (COUNT=100 for fewer)
	PYTHONPATH=tests/support $(BIN)/python tests/support/faults.py --count $(or $(COUNT),1000)

# Programs that agree on no version of a library with our own tools have environments of their own.
pip_in = $(BIN)/python -m venv $(VENV)/$(1) && $(VENV)/$(1)/bin/python -m pip --disable-pip-version-check --quiet install $(2)

readers: build-dev ## Let every program that reads our sets read one, and print a table (minutes)
	@$(call quietly,Installing the programs that read our sets (the first time takes some minutes),{ \
		$(PIP) install torchvision tabulate $(if $(NCORE_CLONE),nvidia-ncore debugpy tqdm) \
		&& $(PIP) install --no-deps trackeval \
		&& $(call pip_in,readers/numpy1,'py123d[nuscenes]' 'pyarrow<23') \
		&& $(call pip_in,readers/numpy2,datumaro fiftyone); })
	@PYTHONPATH=python:tests/support $(BIN)/python -m readers $(DEMO)/readers $(BIN)/python $(VENV)/readers/*/bin/python

golden: build ## Renew the hashes of frames that tests/cadet/generate/test_golden_bytes.py makes again
	$(BIN)/python tests/support/golden_frames.py --write

bench: check-rust ## Measure the core with criterion
	cargo bench --locked -p cadet_bench

bench-peers: WITHOUT_AVOD := yes
bench-peers: build-dev ## Time the ideal scan against Embree, rays and packets, and parry
	$(BIN)/python benches/peers.py

bench-tables: WITHOUT_AVOD := yes
bench-tables: build-dev ## Print the parts of a sample, an image, and a scan (needs Linux's perf; minutes)
	$(BIN)/python benches/tables.py

bench-traffic: WITHOUT_AVOD := yes
bench-traffic: build-dev ## Let 200 episodes run: who overlaps, floats, sinks, or stands (half an hour)
	$(BIN)/python benches/traffic.py -n 200 --workers 2

bench-gpu: build-dev ## Try benches/gpu/run.sh on the CPU with eight frames and a small network (a minute or two)
	@rm -rf $(DEMO)/gpu
	PATH=$(CURDIR)/$(BIN):$$PATH PYTHON=$(BIN)/python OUT=$(DEMO)/gpu WORK=$(DEMO)/gpu/work FRAMES=8 HELD_OUT=4 \
		MINUTES=0.3 TRIAL_STEPS=2 CONFIG=tiny_car DEVICE=cpu AMP= COMPILE= benches/gpu/run.sh

gallery: build ## Draw every family of actors, every district in several weathers, and scans to gallery/ (minutes)
	$(BIN)/cadet gallery gallery $(if $(REAL),--real $(REAL))

$(BIN)/mkdocs: | $(BIN)/python
	@$(PIP) install 'mkdocs>=1.6.1' 'mkdocs-material>=9.6' 'mkdocstrings[python]>=0.30'

docs: $(BIN)/mkdocs ## Build the documentation's site into site/; a dead link or a page outside the menu is an error
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo "Look at site/index.html"

fmt: check-rust $(BIN)/ruff ## Format Rust and Python
	cargo fmt --all
	$(BIN)/ruff check --fix --exit-zero --quiet
	$(BIN)/ruff format

clean: ## Remove .venv, target/, demo/ and site/
	rm -rf $(VENV) target $(DEMO) site python/cadet/_cadet*.so

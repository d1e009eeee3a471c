# Every target sets itself up: the first one that is run builds .venv from constraints.txt.
#   make train ARGS="--seed 1 --train.footsteps 50000"    options go through ARGS
#   make train EXTRAS=dev,docs,cuda                       for an NVIDIA GPU

SHELL := /bin/bash
PYTHON ?= python3
EXTRAS ?= dev,docs
ARGS ?=

VENV := .venv
BIN := $(VENV)/bin
# One stamp per choice of extras, so that asking for cuda later installs it.
READY := $(VENV)/.installed-$(EXTRAS)

.DEFAULT_GOAL := help
.PHONY: help train test test-all bench report paper ros results results-docs docs lint tune models page clean

help: ## show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-13s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

train: $(READY) ## train a policy into runs/<date-time>
	$(BIN)/jaxwalk train $(ARGS)

test: $(READY) ## the tests, the slow ones left out
	$(BIN)/python -m pytest -q -n auto --dist loadfile --no-loadscope-reorder $(ARGS)

test-all: $(READY) ## all tests
	$(BIN)/python -m pytest -q -n auto --dist loadfile --no-loadscope-reorder -m "slow or not slow" $(ARGS)

bench: $(READY) ## bare mjx.step, the tick and training, measured (ARGS="--stages", "--batches 64,256,1024,4096,16384")
	$(BIN)/jaxwalk bench $(ARGS)

report: $(READY) ## one page of everything about a policy (ARGS="runs/NAME --out page.html")
	@mkdir -p runs
	$(BIN)/jaxwalk report $(or $(ARGS),shipped --out runs/report.html)

# Small samples go elsewhere: they are never taken for, nor written over, full ones.
paper: $(READY) ## every claim of the paper, measured, into docs/paper (QUICK=1: small samples, into runs/paper-quick; RETRAIN=1)
	@mkdir -p docs/paper
	$(BIN)/jaxwalk paper --out $(if $(QUICK),runs/paper-quick --trained docs/paper --quick,docs/paper) \
		$(if $(RETRAIN),--retrain) $(ARGS)

ros: $(READY) ## walk through ROS and push the walker (it takes Debian's ROS and libode8; ARGS="--seconds 60")
	@mkdir -p runs
	$(BIN)/jaxwalk ros shipped --out runs/ros --push 40 $(ARGS)

results: $(READY) ## everything in docs/results, measured anew (QUICK=1: a rehearsal, in runs/results-quick)
	$(BIN)/python scripts/results.py $(if $(QUICK),--quick) $(ARGS)

results-docs: $(READY) ## the tables of README.md and docs/ from docs/results
	$(BIN)/python scripts/render_results.py $(ARGS)

docs: $(READY) ## the documentation as a site, in build/site
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict $(ARGS)

lint: $(READY) ## style, types, and the order of imports
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports

tune: $(READY) ## search for a walk: the numbers of the legs and of their step plan (ARGS="--minutes 15 --out tuned.json")
	$(BIN)/python scripts/tune.py $(ARGS)

models: $(READY) ## write models/*.xml anew from jaxwalk/model/anthropometry.py
	$(BIN)/python scripts/make_models.py

page: $(READY) ## compile the walkers of pages anew (it takes Debian's clang and lld): jaxwalk/show/play/modules
	$(BIN)/python scripts/make_page.py

clean: ## remove the environment and caches; runs/ stays
	rm -rf $(VENV) dist build .pytest_cache .ruff_cache *.egg-info
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

$(READY): pyproject.toml constraints.txt
	@echo "setting up $(VENV) ..."
	@$(PYTHON) -m venv --clear $(VENV) || { echo "$(PYTHON) cannot make environments: on Debian, apt-get install python3-venv" >&2; exit 1; }
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[$(EXTRAS)]'
	@touch $@

# make run | make test | make help. Everything lives in .venv, built from the pinned, hashed requirements.
PYTHON ?= python3
CORES ?= all
ENVIRONMENT := .venv
BIN := $(CURDIR)/$(ENVIRONMENT)/bin
STAMP := $(ENVIRONMENT)/installed

.PHONY: help run published test lint types requirements environment
.DEFAULT_GOAL := help

help:  ## this list
	@sed -n 's/^\([a-z]*\):.*##/  make \1\t/p' $(MAKEFILE_LIST) | expand -t 22

run: $(STAMP)  ## the default campaign, from raw logs to results/fixture/report.html
	$(BIN)/snakemake --cores $(CORES)
	@echo "Open results/fixture/report.html"

published: $(STAMP)  ## the published recordings (their folder: config/published.yaml)
	$(BIN)/snakemake --cores $(CORES) --configfile config/published.yaml

# Beside other work the threads of a linear algebra library wait for one another: one does as well.
# Two processes, a file each at a time: files share what they have made.
test: export OPENBLAS_NUM_THREADS = 1
test: lint types  ## all checks: linter, formatter, types, tests
	$(BIN)/python -m pytest -n 2 --dist loadfile

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(STAMP)
	$(BIN)/mypy

environment: $(STAMP)  ## .venv with everything in it

$(STAMP): requirements.txt pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit("Python 3.11 or newer is needed, this is " + sys.version) if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv $(ENVIRONMENT)
	$(BIN)/python -m pip install --disable-pip-version-check --quiet --require-hashes -r requirements.txt
	$(BIN)/python -m pip install --disable-pip-version-check --quiet --no-deps --no-build-isolation -e .
	@touch $@

requirements:  ## pin requirements.in anew (needs uv)
	uv pip compile requirements.in -o requirements.txt --universal --python-version 3.11 --generate-hashes --no-header

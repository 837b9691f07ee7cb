# Two commands do everything on a fresh machine: `make run` and `make test`. Set-up is skipped when nothing changed.
SHELL := bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
STAMP := .venv/.installed
PY := .venv/bin/python
PROFILE ?= quick

export DAGSTER_HOME := $(CURDIR)
export DO_NOT_TRACK := 1
export HF_HUB_OFFLINE := 1
export HF_HUB_DISABLE_TELEMETRY := 1

.PHONY: help setup run test lint bench prove ui lock slow clean

help:  ## list the commands
	@grep -hE '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 10

setup: $(STAMP)  ## make .venv from the pinned, hashed requirements

$(STAMP): requirements.txt pyproject.toml .python-version
	@bash scripts/setup.sh
	@touch $@

run: $(STAMP)  ## scan to scaling curve; PROFILE=quick|smoke|study|paper
	@.venv/bin/sim1 run --profile $(PROFILE)

test: $(STAMP)  ## the fast tests
	@$(PY) -m pytest

slow: $(STAMP)  ## the slow proofs
	@$(PY) -m pytest -m slow

lint: $(STAMP)  ## style, import rules
	@.venv/bin/ruff check .
	@.venv/bin/ruff format --check .

prove: $(STAMP)  ## conceal physics in 60 cases, diagnose blind, score, ask oracle and simpler methods; hours, goes on where it was
	@if [ -e build/proof/answers/drawn.json ]; then .venv/bin/sim1 prove; else .venv/bin/sim1 prove --cases 60; fi
	@.venv/bin/sim1 prove --oracle
	@.venv/bin/sim1 prove --baselines

bench: $(STAMP)  ## timings, as ratios within one run
	@$(PY) -m benchmarks

ui: $(STAMP)  ## Dagster UI with schedules and automation
	@.venv/bin/sim1 ui

lock:  ## compile requirements.txt from pyproject.toml
	uv pip compile pyproject.toml --extra dev --python-version 3.13 --generate-hashes --no-annotate --no-header \
	  --no-emit-index-url --no-emit-find-links -q -o requirements.txt

clean: $(STAMP)  ## remove made artifacts (keeps the set-up)
	@.venv/bin/sim1 clean --all --yes

# A fresh machine needs Python 3.11 or later (with its venv, ssl and sqlite3 modules) and make; the rest is done here.
#
#   make demo          six simulated robots in the terminal; no account, no ROS
#   make test          every check and every test
#   make servers       install what tests use and no wheel brings (by apt, as root or with sudo), and Synapse in an environment of its own; nothing where it is there
#   make check         the checks alone: style, types, imports
#   make pictures      draw the chats and the page in docs/pictures anew, from what is said today
#   make campaign      the long runs; hours, not minutes
#   make mutants       change safety code at random, and see which tests notice; hours, goes on where it was cut off
#   make texts         collect what ROSIC says for its translators, and compile it; write what docs show of the source
#   make requirements  work out the pinned versions anew (UPGRADE=1: the newest that fit)
#   make clean         remove the environment and whatever was built
#
#   PYTHON=/path/to/python     choose the interpreter
#   TESTS=tests/core           run a part;  PYTEST_ARGS='-x -k stop'  passes anything else on
#   WORKERS=0                  run tests one after another; else the files are shared out, the longest first
#   MUTANTS='--only order_gate.py'  of one module; --at-most 40: so many of each, --seed 2: others; --write: into docs/mutants.md
#   TEST_SECONDS=2700          the run of tests is over by then, whatever happens; later where the machine is slow

VENV := .venv
BIN := $(VENV)/bin
PYTHON ?=
TESTS ?= tests
WORKERS ?= 4
PYTEST_ARGS ?=
TEST_SECONDS ?= 2700
CAMPAIGN_SECONDS ?= 21600
MUTANTS ?=
UPGRADE ?=

export PIP_DISABLE_PIP_VERSION_CHECK := 1

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
# Two pips at work in one environment would spoil it.
.NOTPARALLEL:
.PHONY: help demo test servers check pictures campaign mutants texts requirements clean

help:
	@sed -n 's/^#   //p' Makefile

demo: $(VENV)/.core
	@$(BIN)/rosic demo

test: check
	$(call bounded,$(TEST_SECONDS)) $(BIN)/python -m tests.alone -n $(WORKERS) --dist loadfile --no-loadscope-reorder $(PYTEST_ARGS) $(TESTS)

servers: $(VENV)/.dev
	@$(BIN)/python -m tests.servers

check: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

pictures: $(VENV)/.dev
	ROSIC_PICTURES=draw $(BIN)/python -m pytest $(PYTEST_ARGS) tests/journeys/test_card.py tests/journeys/test_first_time.py tests/cli/test_first_hour.py tests/console

campaign: $(VENV)/.dev
	$(call bounded,$(CAMPAIGN_SECONDS)) $(BIN)/python -m pytest -m campaign -o faulthandler_timeout=0 $(PYTEST_ARGS) $(TESTS)

mutants: $(VENV)/.dev
	$(BIN)/python -m tests.mutants --seconds $(CAMPAIGN_SECONDS) $(MUTANTS)

# First an interrupt, so that tests put their servers away; then the end, for what does not listen. How long that is, and
# every limit of a test, follows the pace of this machine, which is measured first.
bounded = $(BIN)/python -m tests.bounded $(1)

# ---- the environment ----

# One environment, two sizes: core runs ROSIC with Telegram and pictures, dev also tests it. Their pins agree, so the small one grows into the large
# one in place. A stamp is younger than everything it was installed from.
$(VENV)/.core: requirements/core.txt pyproject.toml src/rosic/__init__.py
	@$(environment)
	@$(call install,core)
	@touch $@

$(VENV)/.dev: requirements/dev.txt pyproject.toml src/rosic/__init__.py
	@$(environment)
	@$(call install,dev)
	@touch $@ $(VENV)/.core

# A stamp says nothing once the interpreter under it is gone.
$(VENV)/.core $(VENV)/.dev: $(shell test -x $(BIN)/python || echo anew)
.PHONY: anew
anew: ;

# Shows how far that is: it takes a minute or two.
install = $(BIN)/python -m tests.install $(1)

# Half an environment, one of an older Python, or one whose interpreter has gone is made anew. A name on the path proves
# nothing (version managers leave names for Pythons that are not installed), so each candidate is asked to run.
usable = -c 'import ensurepip, sqlite3, ssl, sys, venv; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1
candidates = $(or $(PYTHON),python3.13 python3.12 python3.11 python3 python python3.14)
define environment
if $(BIN)/python $(usable) && $(BIN)/python -m pip --version >/dev/null 2>&1; then exit 0; fi; \
for candidate in $(candidates); do \
    if "$$candidate" $(usable); then \
        echo "Making an environment in $(VENV) with $$candidate"; \
        exec "$$candidate" -m venv --clear $(VENV); \
    fi; \
done; \
echo "No Python 3.11 or later with venv, ssl and sqlite3 was found. Install one, or name it with PYTHON=/path/to/python." >&2; \
exit 1
endef

# ---- upkeep ----

# Universal (one file for every supported Python), with hashes, without addresses. The smaller set keeps to the larger;
# the homeserver that tests start has an environment of its own, and keeps to nothing.
compile = $(BIN)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-emit-index-url \
    --custom-compile-command "make requirements"
of_rosic = pyproject.toml requirements/build.in

texts: $(VENV)/.dev
	@$(BIN)/python -m tests.texts $(LANGUAGE)
	@$(BIN)/python -m tests.commands
	@$(BIN)/python -m tests.quality
	@$(BIN)/python -m tests.architecture

requirements:
	@test -x $(BIN)/uv || $(MAKE) $(VENV)/.dev
	$(compile) $(of_rosic) --extra dev $(if $(UPGRADE),--upgrade) --output-file requirements/dev.txt
	$(compile) $(of_rosic) --constraint requirements/dev.txt --no-annotate --extra telegram --extra pictures \
	    --output-file requirements/core.txt
	$(compile) requirements/synapse.in --only-binary :all: $(if $(UPGRADE),--upgrade) --output-file requirements/synapse.txt

clean:
	rm -rf $(VENV) build dist .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find src tests -name __pycache__ -type d -prune -exec rm -rf {} +

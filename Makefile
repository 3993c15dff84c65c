# Every target sets itself up from a bare clone: `make demo`, `make test`, `make check`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check
TORCH := $(shell sed -n 's/^torch==/torch==/p' constraints.txt)
SITE = NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --strict -f docs/site/mkdocs.yml
COMPAT := tests/env tests/packaging/test_plugin.py tests/agents/test_train.py tests/agents/test_play.py
SETUP := pyproject.toml constraints.txt $(wildcard packaging/*)

.PHONY: demo test slow compat check docs format clean

demo: $(VENV)/.core
	$(BIN)/regionslam run "go to the kitchen" --seed 1 --out out/demo

test: $(VENV)/.test
	$(BIN)/python -m pytest -q

slow: $(VENV)/.test
	$(BIN)/python -m pytest -q -m slow

# The tests of the environments with Gymnasium 1.2.2, which ray pins, and with the newest one.
compat: $(VENV)/.test
	@for version in "==1.2.2" ">=1.2,<2"; do \
		rm -rf $(VENV)/gymnasium && $(PIP) install -q --no-deps --no-compile --target $(VENV)/gymnasium "gymnasium$$version" || exit; \
		export PYTHONPATH=$(abspath $(VENV))/gymnasium; \
		$(BIN)/python -c 'import gymnasium, stable_baselines3; print("gymnasium", gymnasium.__version__, "with stable-baselines3", stable_baselines3.__version__)' || exit; \
		$(BIN)/python -m pytest -q $(COMPAT) || exit; \
	done

check: $(VENV)/.check $(VENV)/.docs
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(SITE)

docs: $(VENV)/.docs
	$(SITE)
	@echo "The site is in build/site; $(BIN)/mkdocs serve -f docs/site/mkdocs.yml shows it while you write."

format: $(VENV)/.check
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean:
	rm -rf $(VENV) build dist *.egg-info .pytest_cache .ruff_cache .mypy_cache

$(VENV)/.created:
	@$(PYTHON) -c 'import sys; sys.exit("regionslam-env needs Python 3.11 or newer, this is " + sys.version.split()[0] + "; try: make PYTHON=python3.11" if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv $(VENV)
	@touch $@

$(VENV)/.core: $(VENV)/.created $(SETUP)
	$(PIP) install -q --no-compile -c constraints.txt -e .
	@touch $@

# PyPI's torch for Linux brings 3 GB of CUDA: take a CPU wheel that pip is set up with, else PyTorch's own CPU index.
$(VENV)/.test: $(VENV)/.core
	@$(PIP) install -q --no-compile --no-deps --no-index "$(TORCH)" 2>/dev/null \
		|| $(PIP) install -q --no-compile --no-deps --retries 1 --timeout 20 --index-url https://download.pytorch.org/whl/cpu "$(TORCH)" 2>/dev/null \
		|| true
	$(PIP) install -q --no-compile -c constraints.txt -e ".[test]"
	@touch $@

$(VENV)/.check: $(VENV)/.core
	$(PIP) install -q --no-compile -c constraints.txt -e ".[check]"
	@touch $@

$(VENV)/.docs: $(VENV)/.core
	$(PIP) install -q --no-compile -c constraints.txt -e ".[docs]"
	@touch $@

# Two commands: `make demo` and `make test`; both do all the set-up they need.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin

.PHONY: demo test bench models pictures clean

demo: $(VENV)/installed
	$(BIN)/hexathermal demo

test: $(VENV)/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache
	$(BIN)/python -m pytest -n 2

bench: $(VENV)/installed
	$(BIN)/pip install -q -e '.[bench]'
	$(BIN)/python -m benchmarks

models: $(VENV)/installed
	$(BIN)/python tools/make_models.py

pictures: $(VENV)/installed
	$(BIN)/python tools/draw_models.py
	$(BIN)/hexathermal demo --out $(VENV)/demo
	cp $(VENV)/demo/day.png docs/demo.png

$(VENV)/installed: pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or later is needed")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install -q --disable-pip-version-check -e '.[dev]'
	touch $@

clean:
	rm -rf $(VENV) .mypy_cache .ruff_cache .pytest_cache .hypothesis dist

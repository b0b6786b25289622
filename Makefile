# Two commands: `make demo` and `make test`; both do all the set-up they need.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin

.PHONY: demo test test-all checked bench models pictures docs docs-check clean

demo: $(VENV)/installed
	$(BIN)/hexathermal demo

# Long tests take about an hour of one core: a twentieth of them, others each day.
test: checked
	$(BIN)/python -m pytest -n 2 --dist worksteal --share $$(( $$(date +%s) / 86400 % 20 + 1 ))/20

test-all: checked
	$(BIN)/python -m pytest -n 2 --dist worksteal

checked: $(VENV)/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache

bench: $(VENV)/installed
	$(BIN)/pip install -q -e '.[bench]'
	$(BIN)/python -m benchmarks

models: $(VENV)/installed
	$(BIN)/python tools/make_models.py

pictures: $(VENV)/installed
	$(BIN)/python tools/draw_models.py
	$(BIN)/hexathermal demo --out $(VENV)/demo
	cp $(VENV)/demo/day.png docs/demo.png
	$(BIN)/python tools/draw_docs.py
	$(BIN)/python tools/draw_viewer.py
	$(BIN)/python tools/draw_report.py

docs: $(VENV)/installed
	$(BIN)/python -m sphinx -W --keep-going -q -b html -d docs/_build/doctrees docs docs/_build/html
	@echo "open docs/_build/html/index.html"

docs-check: $(VENV)/installed
	$(BIN)/python -m sphinx -W --keep-going -q -b linkcheck -d docs/_build/doctrees -D nb_execution_mode=off docs \
	    docs/_build/links
	$(BIN)/python -m pytest -q tests/test_docs.py tests/test_docs_site.py tests/test_docs_words.py

$(VENV)/installed: pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or later is needed")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install -q --disable-pip-version-check -e '.[dev]'
	touch $@

clean:
	rm -rf $(VENV) docs/_build docs/reference/generated docs/notebooks .mypy_cache .ruff_cache .pytest_cache .hypothesis dist

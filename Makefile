# make run    sets up and shows two arms palletizing in the browser     (ARGS=--headless: without)
# make serve  the same with an empty cell to build in
# make test   sets up and checks everything that a change can break: lint and tests (minutes; docs/testing.md)
# make test-all  that, and what takes longer: all models, installations, whole demos
# make hunt   runs the tests that draw random numbers again and again with fresh seeds   (MINUTES=10 ROOM=unit/motion SEED=1)
# make durations  tells the 40 slowest tests and files of the last run
# make bench  sets up and measures against the named peers -> benchmarks/RESULTS.md
# make stubs  writes the Python stubs and the reference after a change of the contract
# make image   accepts a break of the contract: writes the image that make test compares it with
# make picture  takes the pictures of the docs, the README's of the running demo among them
# make console  builds the page of `virtualrobot console`; run, test and wheel do, too
# make wheel   writes the wheel, with the built page, to dist/
# make profiles  draws the pictures of each kind of motion, as the kernel plans it, and those of the sensor models
# make constraints  writes constraints.txt with today's versions
#
# Windows, without make:
#   py -3.11 -m venv .venv
#   .venv\Scripts\pip install -e .[kernel,closed-form]
#   .venv\Scripts\virtualrobot demo

# 3.11, since pybullet, whose robot models most pages and tests load, has no wheels for later ones, which will do as well:
# make run PYTHON=python3.13
PYTHON ?= python3.11
VENV := .venv
BIN := $(VENV)/bin
INSTALL := $(BIN)/python -m pip install -qq --disable-pip-version-check
NODE_BIN := node_modules/.bin
# What the console's page is built from; its stubs are of the contract.
PAGE := clients/python/virtualrobot_apps/console/page/app/index.html
# What is built beside it: the player of .html recordings.
PLAYER := clients/python/virtualrobot/recording/player/player.js
WEB := clients/python/virtualrobot_apps/console/web
PAGE_SOURCES := $(shell find $(WEB) -type f -not -path '*/node_modules/*' -not -path '*/generated/*') $(wildcard proto/virtualrobot/v1/*.proto)
# The contract that clients are promised.
IMAGE := proto/image.binpb

MAKEFLAGS += --no-print-directory
# Whatever the shell says: without its bytecode each of some hundred processes compiles the kernel's modules anew.
export PYTHONDONTWRITEBYTECODE :=
.PHONY: run serve test test-all test-long long compiled pytest pytest-long hunt durations bench lint ruff pyright buf image stubs constraints picture profiles console wheel clean
.DELETE_ON_ERROR:

# Without the page there is still the viewer.
run: $(VENV)/installed-kernel
	@$(MAKE) console || true
	@$(BIN)/virtualrobot demo $(ARGS)

serve: $(VENV)/installed-kernel
	@$(MAKE) console || true
	@$(BIN)/virtualrobot serve $(ARGS)

console: $(PAGE) $(PLAYER)

$(PAGE): $(PAGE_SOURCES) tools/build_page.py | $(VENV)/bin/python
	@echo "building the console's page ..."
	@$(BIN)/python tools/build_page.py
	@touch $@

$(PLAYER): $(PAGE)
	@test -e $@ || $(BIN)/python tools/build_page.py
	@touch $@

wheel: $(PAGE) $(PLAYER)
	@$(BIN)/python -m pip wheel -q --no-deps -w dist .

# Side by side: what pip and npm set up, and what is compiled meanwhile.
test:
	@$(MAKE) -j3 ruff buf console compiled
	@$(MAKE) pytest

test-all: test
	@$(MAKE) test-long

# Types need no compilers, and are checked while these are fetched.
test-long:
	@$(MAKE) -j2 pyright long

long:
	@if command -v apt-get > /dev/null; then tools/install_toolchains.sh; fi
	@$(MAKE) pytest-long

# By file, in order: the long files come first. Three workers for two cores, since tests wait for motions in real time; long
# ones start kernels, browsers and controllers of their own, and have two.
WORKERS := 3
PYTEST = $(BIN)/python -m pytest -q -n $(WORKERS) --dist loadfile --no-loadscope-reorder

# Deadlines of components are no time to compile in.
compiled: $(VENV)/installed-dev
	@$(BIN)/python tools/compile_code.py

pytest: $(VENV)/installed-dev $(PAGE) compiled
	@echo "testing ..."
	@$(PYTEST) --junitxml=$(VENV)/tests.xml $(ARGS)

pytest-long: WORKERS := 2
pytest-long: $(VENV)/installed-dev $(PAGE)
	@echo "testing what takes long ..."
	@$(PYTEST) -m long --junitxml=$(VENV)/tests-long.xml $(ARGS)

hunt: $(VENV)/installed-dev
	@$(BIN)/python tools/hunt.py --minutes $(or $(MINUTES),10) $(if $(SEED),--seed $(SEED)) tests/$(ROOM)

durations:
	@$(BIN)/python tools/slowest_tests.py $(wildcard $(VENV)/tests.xml $(VENV)/tests-long.xml)

bench: $(VENV)/installed-bench
	@$(BIN)/python -m benchmarks.run $(ARGS)

lint: ruff pyright buf

ruff: $(VENV)/installed-dev
	@echo "ruff ..."
	@$(BIN)/ruff check --quiet && $(BIN)/ruff format --check --quiet

# In two parts, three minutes of a core each: what it keeps of everything at once is more than it may hold, and is made twice.
pyright: $(VENV)/installed-dev node_modules/.package-lock.json
	@for part in "kernel plugins clients/python tools" "tests benchmarks"; do \
		echo "pyright of $$part ..."; \
		$(NODE_BIN)/pyright --pythonpath $(BIN)/python $$part > $(VENV)/pyright.log || { cat $(VENV)/pyright.log; exit 1; }; \
	done

buf: node_modules/.package-lock.json
	@echo "buf lint ..."
	@$(NODE_BIN)/buf lint
	@echo "buf breaking ..."
	@$(NODE_BIN)/buf breaking --against $(IMAGE) || { echo "the contract breaks clients: mend it, or add a line to CHANGELOG.md and run: make image"; exit 1; }

image: node_modules/.package-lock.json
	@$(NODE_BIN)/buf build --exclude-source-info -o $(IMAGE)

stubs: $(VENV)/bin/python
	@$(BIN)/python tools/generate_stubs.py
	@$(BIN)/python tools/generate_reference.py
	@$(BIN)/python tools/generate_functions.py
	@$(BIN)/python tools/generate_rapid.py
	@$(BIN)/python tools/generate_rapl.py
	@$(BIN)/python tools/generate_urscript.py
	@$(BIN)/python tools/generate_abb.py
	@$(BIN)/python tools/generate_aio.py

constraints: $(VENV)/bin/python
	@$(BIN)/python tools/pin_versions.py

# The README's picture, of the running demo, and others that the kernel takes.
picture: $(VENV)/installed-dev $(PAGE)
	@$(BIN)/python tools/picture.py docs/pictures
	@$(BIN)/python tools/picture_sensors.py docs/pictures
	@$(BIN)/python tools/picture_cameras.py docs/pictures
	@$(BIN)/python -m tools.picture_console docs/pictures
	@$(BIN)/python -m tools.picture_console_tools docs/pictures
	@$(BIN)/python -m tools.picture_room docs/pictures
	@$(BIN)/python tools/picture_boebot.py docs/pictures

# The pictures of docs/motion-profiles.md, docs/sensor-models.md, docs/recording.md, docs/avoidance.md, docs/demo-carry.md, docs/ugv.md and docs/boebot.md.
profiles: $(VENV)/installed-dev
	@$(BIN)/python tools/plot_motions.py docs/pictures
	@$(BIN)/python tools/plot_sensor_models.py docs/pictures
	@$(BIN)/python tools/plot_recording.py docs/pictures
	@$(BIN)/virtualrobot avoid --headless --stepped --plot docs/pictures/avoidance.svg
	@$(BIN)/virtualrobot demo carry --headless --plot docs/pictures/carry.svg
	@$(BIN)/virtualrobot demo ugv --headless --plot docs/pictures/ugv.svg
	@$(BIN)/virtualrobot demo boebot --headless --plot docs/pictures/boebot.svg
	@$(BIN)/virtualrobot demo maze --headless --plot docs/pictures/maze.svg

clean:
	@rm -rf $(VENV) node_modules clients/node/node_modules clients/node/dist $(WEB)/node_modules $(WEB)/src/generated $(dir $(PAGE)) build dist *.egg-info .pytest_cache .ruff_cache

$(VENV)/bin/python:
	@command -v $(PYTHON) > /dev/null || { echo "$(PYTHON) is missing; install it (with venv), or name another: make PYTHON=..."; exit 1; }
	@$(PYTHON) -m venv $(VENV)

$(VENV)/installed-kernel: pyproject.toml constraints.txt | $(VENV)/bin/python
	@echo "setting up the kernel in $(VENV) ... (once, about 1 minute)"
	@$(INSTALL) -c constraints.txt -e '.[kernel,closed-form,video]'
	@touch $@

$(VENV)/installed-dev: pyproject.toml constraints.txt | $(VENV)/bin/python
	@echo "setting up the kernel and the test tools in $(VENV) ... (once, about 2 minutes)"
	@$(INSTALL) -c constraints.txt -e '.[kernel,dev]'
	@touch $@ $(VENV)/installed-kernel

$(VENV)/installed-bench: pyproject.toml constraints.txt | $(VENV)/bin/python
	@echo "setting up the kernel and the peers that it is measured against in $(VENV) ... (once, about 2 minutes)"
	@$(INSTALL) -c constraints.txt -e '.[kernel,dev,bench]'
	@touch $@ $(VENV)/installed-kernel $(VENV)/installed-dev

node_modules/.package-lock.json: package.json package-lock.json
	@command -v npm > /dev/null || { echo "npm is missing: it brings buf and pyright; install Node.js 18 or later"; exit 1; }
	@echo "setting up buf and pyright ... (once)"
	@npm ci --loglevel=error --no-fund > /dev/null
	@touch $@

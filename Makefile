# Everything about Lumenray that is started by hand or by continuous integration.

VENV ?= $(CURDIR)/.venv
PYTHON_IN_VENV := $(VENV)/bin/python
OUT ?= out

export VENV

.DEFAULT_GOAL := help
.PHONY: help setup demo scenes luminaires materials test test-slow test-all validate mutations lint extension denoiser cluster zips-check weaknesses smoke farm enabling viewer page-pictures viewport surroundings panels docs-screenshots

help: ## this list
	@echo "make TARGET, where TARGET is one of:"
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  \1|\2/p' $(firstword $(MAKEFILE_LIST)) \
		| while IFS='|' read -r target text; do printf '  %-18s %s\n' "$$target" "$$text"; done

setup: ## make the virtual environment and check the system libraries (quick when all is there)
	@packaging/bootstrap.sh

demo: setup ## render and bake a bundled scene into out/
	$(VENV)/bin/lumenray demo --force -o $(OUT)

scenes: setup ## build the bundled scenes anew with a real Blender (root)
	@tests/real_blender/write_library.sh scenes

luminaires: setup ## compute the library's luminaires anew, render what has no picture, write assets with a real Blender (root)
	$(PYTHON_IN_VENV) -m lumenray.tools.libraries.luminaires files
	$(PYTHON_IN_VENV) -m lumenray.tools.libraries.luminaires assets
	@tests/real_blender/write_library.sh luminaires

materials: setup ## compute the library's materials anew, render them and write their assets with a real Blender (root)
	$(PYTHON_IN_VENV) -m lumenray.tools.libraries.materials files
	$(PYTHON_IN_VENV) -m lumenray.tools.libraries.materials assets --pictures all --force --sheet docs/pictures/material_library.png
	@tests/real_blender/write_library.sh materials

# Two at a time: while one waits, for an engine that starts or a kernel that is compiled, the other computes.
test: setup ## run the tests, all but the slow ones and those that need a real Blender
	$(PYTHON_IN_VENV) -m pytest -n 2 --dist worksteal -m "not slow"

test-slow: setup ## run the slow tests until one fails
	$(PYTHON_IN_VENV) -m pytest -n 2 --dist worksteal -m slow --exitfirst

test-all: test test-slow ## run all tests

validate: setup ## run the whole validation suite, other programs too, and write its report into docs/validation
	$(VENV)/bin/lumenray validate --peers

mutations: setup ## put faults of physics into the engine, see that the quick subset finds each, and write the table
	$(PYTHON_IN_VENV) -m lumenray.validation.mutations -o docs/validation

lint: setup ## check style, format and the direction of imports
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/lint-imports

extension: setup ## build the extension's zips for this platform into dist/
	$(PYTHON_IN_VENV) packaging/build_extension.py

denoiser: setup ## build the denoiser pack for this platform, an extension of its own, into dist/
	$(PYTHON_IN_VENV) packaging/denoiser_pack.py

cluster: setup ## build the cluster pack for this platform, an extension of its own, into dist/
	$(PYTHON_IN_VENV) packaging/cluster_pack.py

zips-check: setup ## build the zips of all systems into dist/, check them by reading, and print what was found
	$(PYTHON_IN_VENV) packaging/build_extension.py --all
	$(PYTHON_IN_VENV) packaging/denoiser_pack.py --all
	$(PYTHON_IN_VENV) packaging/cluster_pack.py --all
	$(PYTHON_IN_VENV) packaging/platform_report.py

weaknesses: setup ## look the pinned versions up among known weaknesses: folders or zips in OSV's form, DATA="all.zip ..."
	$(PYTHON_IN_VENV) packaging/known_weaknesses.py $(DATA)

smoke: setup ## install the zip into a real Blender, render and bake there (root; 3 GB the first time; BLENDER=5.2 for another)
	@LUMENRAY_BLENDER="$(or $(BLENDER),4.3)" tests/real_blender/run_smoke.sh

farm: setup ## do the tasks of Flamenco's jobs by hand in a real Blender (root, Node.js)
	@tests/real_blender/run_farm.sh

enabling: setup ## tell what enabling the extension takes in a real Blender (root)
	@tests/real_blender/run_enabling.sh

viewer: setup ## load an exported scene in three.js, and use the service's page, in a headless Chromium (root the first time)
	@tests/viewer/setup.sh
	$(PYTHON_IN_VENV) -m pytest tests/viewer

page-pictures: setup ## take the guide's pictures of the service's page into docs/pictures (root the first time)
	@tests/viewer/setup.sh
	$(PYTHON_IN_VENV) tests/viewer/take_pictures.py docs/pictures

viewport: setup ## use the rendered view in a real Blender's window: pictures, faults, memory, closing (root)
	@tests/real_blender/run_viewport.sh

surroundings: setup ## drag suns, raise a ground and drop pictures of surroundings in a real Blender's window (root)
	@tests/real_blender/run_environment.sh

panels: setup ## take pictures of every panel at default width into out/real-blender/panels (root)
	@tests/real_blender/run_panels.sh

docs-screenshots: setup ## take the guide's pictures of Blender's window into docs/pictures (root)
	@tests/real_blender/screenshots.sh
	@tests/real_blender/start_panel.sh
	@LUMENRAY_BLENDER=5.2 tests/real_blender/start_panel.sh

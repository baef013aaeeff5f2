"""Reports as JSON."""

import json


def test_reports_are_json_with_the_stated_fields(tmp_path):
    from lumenray.engine.formats.report import compose, write_json
    from lumenray.engine.session import Provenance

    provenance = Provenance("0.1.0", "llvm_ad_mono", "abc", 3, 64, 1.5)
    path = write_json(tmp_path / "r.json", compose("a.blend", provenance, 2.0, []))
    made = json.loads(path.read_text())
    assert made["engine"] == {"version": "0.1.0", "variant": "llvm_ad_mono"}
    assert made["scene"] == {"file": "a.blend", "hash": "abc"}
    assert made["seed"] == 3

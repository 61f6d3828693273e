"""The file of payloads by which the phone is tested says what the codec says now."""

import json

from tests.vectors.tag_memories import FILE, vectors


def test_the_vectors_are_what_the_codec_says():
    """If this fails because the codec changed: `python -m tests.vectors.tag_memories`."""
    kept = json.loads(FILE.read_text())
    assert len(kept) > 100
    assert kept == json.loads(json.dumps(vectors()))
    assert {vector["condition"] for vector in kept} == {"empty", "read", "unreadable"}

"""The vectors that the phone is held to are what the server says."""

import json

from tests.vectors.node_places import FILE, vectors


def test_the_vectors_are_what_the_server_says():
    assert json.loads(json.dumps(vectors())) == json.loads(FILE.read_text())

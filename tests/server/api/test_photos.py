"""Photos as people leave and see them: made safe, kept once, taken away and put back."""

import io
import struct
import zlib
from uuid import uuid4

import numpy as np
import pytest
from PIL import Image

from server.photo_file import MAX_PIXELS, PhotoError, drawn_anew

SECRET = b"48.137154 11.576124 Ada's phone"


def picture(kind="JPEG", size=(640, 480), mode="RGB", **more):
    pixels = np.random.default_rng(1).integers(0, 255, (size[1], size[0], 4), np.uint8)
    pixels[: size[1] // 2, :, :3] = (250, 10, 10)
    image = Image.fromarray(pixels, "RGBA").convert(mode)
    file = io.BytesIO()
    image.save(file, kind, **more)
    return file.getvalue()


def with_secrets():
    exif = Image.Exif()
    exif[0x0112] = 6  # to be turned by a quarter
    exif[0x010F] = SECRET.decode()
    exif.get_ifd(0x8825)[2] = (48.0, 8.0, 13.7)
    return picture(exif=exif.tobytes(), comment=SECRET) + SECRET


def bomb(width, height):
    """A PNG of a few bytes that says it is huge."""
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    pixels = zlib.compress(bytes(100))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


def leave(line, data, **words):
    words = {"photo_id": str(uuid4()), **(words or {"x_m": 1.0, "y_m": 2.0})}
    return line.call("POST", "/photos", params=words, content=data, headers={"Content-Type": "image/jpeg"})


def test_nothing_but_the_picture_is_kept_and_it_stands_upright():
    data = with_secrets()
    assert SECRET in data
    pictures, size = drawn_anew(data)
    assert size == (480, 640)
    for kept, longest in ((pictures.whole, 640), (pictures.small, 320)):
        image = Image.open(io.BytesIO(kept))
        assert SECRET not in kept
        assert (image.format, max(image.size)) == ("JPEG", longest)
        assert not image.getexif()
        assert "icc_profile" not in image.info
        red = np.asarray(image)[:, -image.width // 4 :].mean(axis=(0, 1))  # what was on top is on the right
        assert red[0] > 200 > 60 > red[1]


@pytest.mark.parametrize(
    ("kind", "mode"), [("PNG", "RGBA"), ("PNG", "P"), ("PNG", "L"), ("WEBP", "RGBA"), ("JPEG", "L")]
)
def test_every_kind_of_photo_becomes_a_jpeg(kind, mode):
    pictures, size = drawn_anew(picture(kind, (3000, 30), mode))
    assert size == (2048, 20)
    assert Image.open(io.BytesIO(pictures.small)).size == (320, 3)


@pytest.mark.parametrize(
    "data",
    [b"", b"x" * 1000, picture()[:300], picture("PNG")[:400], picture("GIF"), picture("TIFF"),
     bomb(20_000, 20_000), bomb(2**31 - 1, 2**31 - 1), bomb(7_000, 7_000), b"<svg xmlns='http://www.w3.org/2000/svg'><script/></svg>"],
    ids=["empty", "noise", "cut jpeg", "cut png", "gif", "tiff", "bomb", "overflow", "hollow", "svg"],
)  # fmt: skip
def test_what_is_no_photo_is_refused_in_a_sentence(line, data):
    with pytest.raises(PhotoError):
        drawn_anew(data)
    response = leave(line, data)
    assert (response.status_code, response.json()["error"]["code"]) == (422, "no_photo")
    assert response.json()["error"]["message"].endswith(".")
    assert line.get("/photos") == {"photos": []}


def test_a_photo_of_a_phone_is_not_too_large():
    assert MAX_PIXELS >= 8160 * 6120


def test_the_story_of_a_photo(line):
    data, photo_id = with_secrets(), str(uuid4())
    with line.stream() as stream:
        words = {"photo_id": photo_id, "victim_id": "7", "text": "<b>left</b> arm", "taken_unix_s": 5.5}
        left = leave(line, data, **words)
        assert left.status_code == 201, left.text
        photo = left.json()
        assert (photo["victim_id"], photo["text"], photo["by"]) == ("7", "<b>left</b> arm", "operator")
        assert (photo["width"], photo["height"], photo["taken_unix_s"]) == (480, 640, 5.5)
        stream.until(lambda s: s.state.get(f"photo/{photo_id}") == photo)
        again = leave(line, data, **words)
        assert (again.status_code, again.json()) == (200, photo)
        other = leave(line, picture(), **words)
        assert (other.status_code, other.json()["error"]["code"]) == (409, "photo_differs")
        assert line.get("/photos") == {"photos": [photo]}
        for address, longest in ((photo["address"], 640), (photo["thumbnail"], 320)):
            found = line.control.call("GET", address.removeprefix("/api/v1"))
            assert found.headers["content-type"] == "image/jpeg"
            assert found.headers["x-content-type-options"] == "nosniff"
            assert found.headers["cache-control"].startswith("private")
            assert "sandbox" in found.headers["content-security-policy"]
            assert max(Image.open(io.BytesIO(found.content)).size) == longest
        assert line.call("DELETE", f"/photos/{photo_id}").status_code == 204
        stream.until(lambda s: f"photo/{photo_id}" not in s.state)
        assert line.refused("GET", f"/photos/{photo_id}") == (404, "unknown_photo", None)
        assert leave(line, data, **words).status_code == 200  # a phone that sends it late brings nothing back
        assert line.get("/photos") == {"photos": []}
        entry = next(e for e in line.get("/audit?limit=5")["entries"] if e["action"] == "delete_photo")
        assert line.call("POST", f"/audit/{entry['audit_id']}/undo").status_code == 204
        stream.until(lambda s: s.state.get(f"photo/{photo_id}") == photo)
    assert [event["text"] for event in line.events("photo")] == ["operator left a photo of victim 7."]


def test_a_photo_is_of_one_thing(line):
    for words in (
        {"text": "nothing"},
        {"victim_id": "1", "tag_id": "A1"},
        {"x_m": 1.0},
        {"x_m": "nan", "y_m": 1.0},
        {"tag_id": "A1", "text": "x" * 501},
        {"tag_id": "A1", "photo_id": "1"},
        {"tag_id": "A1", "other": "1"},
        {"annotation_id": "no uuid"},
    ):
        assert leave(line, picture(), **words).status_code == 422, words


def test_photos_are_there_after_a_restart_and_large_bodies_are_for_photos_alone(make_control, tmp_path):
    control = make_control(tmp_path, max_body_bytes=2000, max_photo_bytes=300_000)
    line = control.open()
    photo = leave(line, picture("PNG", (200, 200)), tag_id="A1").json()
    too_large = leave(line, bytes(300_001), tag_id="A1")
    assert (too_large.status_code, too_large.json()["error"]["code"]) == (413, "too_large")
    assert "smaller" in too_large.json()["error"]["message"]
    assert line.refused("PUT", f"/annotations/{uuid4()}", {"kind": "note", "text": "x" * 3000})[0] == 413
    control.stop()
    control.start()
    line = control.line(line.mission_id)
    assert line.get("/photos") == {"photos": [photo]}
    assert line.control.call("GET", photo["thumbnail"].removeprefix("/api/v1")).status_code == 200

"""What makes no sense is refused by an error that names the argument."""

import pathlib
import struct
import sys
import tempfile
import unittest
import zlib

import numpy as np

import cairn
import street
from street import expect_error

KEYPOINTS = np.array([[10.0, 20.0], [30.0, 40.0]])
DESCRIPTORS = np.ones((2, 128), np.float32)


class Arrays(unittest.TestCase):
    def refuse(self, argument, *words, keypoints=KEYPOINTS, descriptors=DESCRIPTORS, **keywords):
        with expect_error(self, "invalid_argument", argument, *words):
            cairn.Features(keypoints, descriptors, **keywords)

    def test_shapes(self):
        self.refuse("keypoints", "(2, 3)", keypoints=np.zeros((2, 3)))
        self.refuse("keypoints", "(4,)", keypoints=np.zeros(4))
        self.refuse("descriptors", "(2,)", descriptors=np.zeros(2, np.float32))
        self.refuse("descriptors", "3 rows", "2 keypoints", descriptors=np.ones((3, 8), np.float32))

    def test_types(self):
        self.refuse("keypoints", "int64", keypoints=KEYPOINTS.astype(int))
        self.refuse("keypoints", "list", keypoints=[[1.0, 2.0]])
        self.refuse("descriptors", "float64", descriptors=DESCRIPTORS.astype(float))
        self.refuse("descriptors", "object", descriptors=DESCRIPTORS.astype(object))
        self.refuse("type", "int", type=3)

    def test_strides(self):
        self.refuse("keypoints", "contiguous", keypoints=np.zeros((2, 8))[:, ::4])
        self.refuse("descriptors", "contiguous", descriptors=np.asfortranarray(DESCRIPTORS))
        self.refuse("descriptors", "contiguous", descriptors=DESCRIPTORS[::-1])

    def test_byte_orders(self):
        self.refuse("keypoints", ">f8", "byte order", keypoints=KEYPOINTS.astype(">f8"))
        self.refuse("descriptors", ">f4", "byte order", descriptors=DESCRIPTORS.astype(">f4"))

    def test_the_byte_order_of_the_machine_by_its_name(self):
        order = "<" if sys.byteorder == "little" else ">"
        descriptors = DESCRIPTORS.view(np.dtype("f4").newbyteorder(order))
        features = cairn.Features(KEYPOINTS, descriptors)
        np.testing.assert_array_equal(features.descriptors, DESCRIPTORS)

    def test_values(self):
        self.refuse("keypoints", keypoints=KEYPOINTS * np.nan)
        self.refuse("size", "0", size=(0, 5))
        self.refuse("size", size=5)

    def test_what_is_right_is_kept_and_seen_without_a_copy(self):
        features = cairn.Features(np.array([[1, 2, 3, 0.5]], np.float32),
                                  np.array([[7, 9]], np.uint8), size=(64, 48))
        np.testing.assert_array_equal(features.keypoints, [[1, 2, 3, 0.5]])
        np.testing.assert_array_equal(features.descriptors, [[7, 9]])
        self.assertTrue(np.shares_memory(features.descriptors, features.descriptors))
        self.assertFalse(features.keypoints.flags.writeable)
        self.assertEqual((features.size, features.type, len(features)), ((64, 48), "sift", 1))
        view = features.descriptors
        del features
        np.testing.assert_array_equal(view, [[7, 9]])


class Images(unittest.TestCase):
    def refuse(self, image, *words):
        with expect_error(self, "invalid_argument", "image", *words):
            cairn.extract(image)

    def test_pixels(self):
        self.refuse(np.zeros((8, 8)), "float64")
        self.refuse(np.zeros((8, 8, 4), np.uint8), "(8, 8, 4)")
        self.refuse(np.zeros((8, 8), np.uint8).T[::2], "contiguous")
        self.refuse(np.zeros((0, 8), np.uint8), "(0, 8)")
        self.refuse(3.5, "float")
        self.refuse(b"", "empty")

    def test_gray_and_color_of_the_same_picture_agree(self):
        gray = np.random.default_rng(1).integers(0, 256, (120, 160), np.uint8)
        gray = np.kron(gray[::8, ::8], np.ones((8, 8), np.uint8))
        of_gray = cairn.extract(gray)
        of_color = cairn.extract(np.repeat(gray[:, :, None], 3, axis=2))
        self.assertGreater(len(of_gray), 20)
        self.assertEqual(of_gray.size, (160, 120))
        np.testing.assert_array_equal(of_gray.descriptors, of_color.descriptors)
        self.assertLessEqual(len(cairn.extract(gray, options={"sift": {"max_features": 5}})), 5)

    def test_files(self):
        with expect_error(self, "not_found", "/nowhere/a.jpg"):
            cairn.extract(pathlib.Path("/nowhere/a.jpg"))
        with expect_error(self, "bad_input"):
            cairn.extract(b"no image")


def with_exif(png, orientation, focal_35mm):
    """A PNG with an EXIF block that states how it was held and its focal length."""
    def directory(*entries):
        return struct.pack("<H", len(entries)) + b"".join(entries) + struct.pack("<I", 0)

    def short(tag, value):
        return struct.pack("<HHIHH", tag, 3, 1, value, 0)

    first = directory(short(0x112, orientation), struct.pack("<HHII", 0x8769, 4, 1, 8 + 30))
    tiff = b"II*\0" + struct.pack("<I", 8) + first + directory(short(0xA405, focal_35mm))
    chunk = b"eXIf" + tiff
    begin = 8 + 25  # Signature and header.
    return (png[:begin] + struct.pack(">I", len(tiff)) + chunk
            + struct.pack(">I", zlib.crc32(chunk)) + png[begin:])


class Exif(unittest.TestCase):
    def test_says_how_the_photo_was_held_and_its_focal_length(self):
        png = (street.files(with_photos=True) / "photos" / "walk_000.png").read_bytes()
        photo = with_exif(png, orientation=6, focal_35mm=26)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "turned.png"
            path.write_bytes(photo)
            camera = cairn.Camera.from_exif(path)
        self.assertEqual(camera.size, (360, 480))
        self.assertEqual(camera.focal_sigma, 0.05)
        self.assertAlmostEqual(camera.params[0], 26 / 36 * 480, delta=0.01)
        self.assertEqual(cairn.extract(photo).size, (360, 480))
        stored = cairn.Camera("PINHOLE", (480, 360), [320, 320, 240, 180])
        self.assertEqual(cairn.extract(photo, stored).size, (480, 360))


class Queries(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.first = street.FirstQuery()
        cls.map = cairn.Map(street.map_path())

    def refuse(self, argument, **keywords):
        with expect_error(self, "invalid_argument", argument):
            self.map.localize(self.first.features(), **{"camera": self.first.camera, **keywords})

    def test_each_argument_is_named(self):
        self.refuse("camera", camera="PINHOLE")
        self.refuse("camera", camera=cairn.Camera("PINHOLE", (64, 48), [50, 50, 32, 24]))
        self.refuse("prior", prior=(91.0, 0.0))
        self.refuse("prior", prior="here")
        self.refuse("prior", prior=(1, 2, 3, 4))
        self.refuse("accuracy_m", accuracy_m=-1)
        self.refuse("accuracy_m", accuracy_m="15")
        self.refuse("gravity", gravity=(0, 0, 0))
        self.refuse("gravity", gravity=(0, float("nan"), 0))
        self.refuse("gravity", gravity=np.eye(3))
        self.refuse("timeout_ms", timeout_ms=0)
        self.refuse("timeout_ms", timeout_ms=1.5)
        self.refuse("exif_prior", exif_prior=1)
        self.refuse("rig", rig=5)

    def test_the_parts_of_a_rig_are_named(self):
        image = self.first.features()
        self.refuse("rig[0]", rig=[(image, self.first.camera)])
        self.refuse("rig[0][1]", rig=[(image, None, np.eye(4))])
        self.refuse("rig[1][2]", rig=[(image, self.first.camera, np.eye(4)),
                                      (image, self.first.camera, np.ones((4, 4)))])

    def test_features_without_a_size_need_a_camera(self):
        features = cairn.Features(self.first.keypoints, self.first.descriptors)
        with expect_error(self, "invalid_argument", "camera", "size"):
            self.map.localize(features)

    def test_a_query_has_its_arguments_already(self):
        with expect_error(self, "invalid_argument", "prior"):
            self.map.localize(self.first.query(), prior=(1, 2))
        with expect_error(self, "invalid_argument", "prior"):
            cairn.Client("http://127.0.0.1:1").localize(self.first.query(), prior=(1, 2))

    def test_batches(self):
        for threads in (-1, 2.5, 5000):
            with expect_error(self, "invalid_argument", "threads"):
                self.map.localize_many([], threads=threads)
        with expect_error(self, "invalid_argument", "queries"):
            self.map.localize_many("photo.jpg")

    def test_places(self):
        for where in ((1, 2, 3), (0, 50, 1, 40), (0, 0, 0, 100), "no tile", -1):
            with expect_error(self, "invalid_argument", "where"):
                self.map.landmarks(where)
        with expect_error(self, "not_found", "where"):
            self.map.landmarks("32N-03104-35120")


class Others(unittest.TestCase):
    def test_cameras(self):
        with expect_error(self, "bad_input", "PINHOLEE"):
            cairn.Camera("PINHOLEE", (64, 48), [1, 2, 3])
        with expect_error(self, "invalid_argument", "params"):
            cairn.Camera("PINHOLE", (64, 48), "abc")
        with expect_error(self, "invalid_argument", "focal_sigma"):
            cairn.Camera("PINHOLE", (64, 48), [50, 50, 32, 24], focal_sigma=2)
        camera = cairn.Camera.unknown((640, 480))
        self.assertEqual((camera.model, camera.size, camera.focal_sigma),
                         ("SIMPLE_RADIAL", (640, 480), 0.25))
        self.assertIn("(640, 480)", repr(camera))

    def test_maps(self):
        with expect_error(self, "not_found", "/nowhere.gpkg"):
            cairn.Map("/nowhere.gpkg")
        with expect_error(self, "invalid_argument", "path_or_url"):
            cairn.Map(5)
        with expect_error(self, "invalid_argument", "cache_mb"):
            cairn.Map(street.map_path(), cache_mb=0)

    def test_options_are_those_of_the_command_line(self):
        for options, word in (({"voting": {"max_candidate": 3}}, "voting.max_candidates"),
                              ({"voting": {"max_candidates": "x"}}, "voting.max_candidates"),
                              ({"voting": {"max_candidates": float("nan")}}, "options"),
                              ({"voting": {1, 2}}, "options"), (7, "options")):
            with expect_error(self, "invalid_argument", word):
                cairn.Map(street.map_path(), options=options)
        with cairn.Map(street.map_path(), options={"seed": np.int64(3)}) as map_:
            self.assertEqual(map_.path, str(street.map_path()))

    def test_servers(self):
        with expect_error(self, "invalid_argument", "ftp"):
            cairn.Client("ftp://example.org")
        with expect_error(self, "invalid_argument", "url"):
            cairn.Client(5)
        with expect_error(self, "invalid_argument", "timeout_ms"):
            cairn.Client("http://localhost:1", timeout_ms=-5)
        with expect_error(self, "unavailable", "http://127.0.0.1:1"):
            cairn.Client("http://127.0.0.1:1").localize(street.FirstQuery().query())


if __name__ == "__main__":
    unittest.main()

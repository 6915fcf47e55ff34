"""Scenes of arrays, and their pictures."""

import numpy as np
import pytest

import diffract
from diffract import Light, Mesh, Object, Scene

SQUARE = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
FACES = [[0, 1, 2], [0, 2, 3]]
UV = (SQUARE[:, :2] + 1) / 2


def test_a_mesh_of_arrays_is_drawn_where_it_stands():
    tile = Object(Mesh(SQUARE, FACES, UV), pigment=(0.2, 0.1, 0.05))
    camera = ((0, 0, 5), (0.0, 0.001, 0), 30)
    scene = Scene([tile], lights=[Light(30, 0)], camera=camera)
    picture = diffract.render(scene, "blaze", size=(48, 48), samples=4, tolerance=0.1)
    alpha = picture[..., 3]
    assert alpha[24, 24] == 1 and alpha[0, 0] == 0
    # A square of side 2 at a distance of 5 under 30° covers (2/5)²/(2 tan 15°)² of the picture.
    assert alpha.mean() == pytest.approx((0.4 / (2 * np.tan(np.radians(15)))) ** 2, rel=0.05)
    moved = Scene([Object(Mesh(SQUARE, FACES, UV), position=(9, 0, 0))], lights=["30,0"], camera=camera)
    assert diffract.render(moved, "blaze", size=(16, 16), samples=1, tolerance=0.1)[..., 3].max() == 0


def test_light_and_material_change_a_picture():
    def brightness(**keywords):
        lights = keywords.pop("lights", ["30,0"])
        picture = diffract.render(
            Scene("sphere", lights=lights), "blaze", size=(32, 32), samples=1, tolerance=0.1, **keywords
        )
        return picture[..., :3].sum()

    one = brightness()
    assert brightness(lights=[Light(30, 0, 2.0)]) > 1.5 * one  # the scene has surroundings, too
    assert brightness(material="aluminium") > 5 * one
    assert brightness(lights=[Light(30, 0), Light.parse("sun:50,90")]) > one


def test_what_a_screen_shows_is_8_bits():
    picture = diffract.render("plate", "blaze", size=(16, 9), samples=1, tolerance=0.1)
    shown = diffract.srgb(picture, exposure=2)
    assert shown.shape == (9, 16, 3) and shown.dtype == np.uint8
    np.testing.assert_array_equal(shown[..., 0] > 0, diffract.srgb(picture[..., :3], 2)[..., 0] > 0)


@pytest.mark.parametrize(
    ("make", "name", "kind"),
    [
        (lambda: Mesh(SQUARE[:, :2], FACES), "vertices", ValueError),
        (lambda: Mesh(SQUARE, [[0, 1]]), "faces", ValueError),
        (lambda: Mesh(SQUARE, [[0, 1, 4]]), "faces", ValueError),
        (lambda: Mesh(SQUARE, [[0, 1, 1.5]]), "faces", ValueError),
        (lambda: Mesh(SQUARE, FACES, UV[:2]), "texture", ValueError),
        (lambda: Mesh(SQUARE * np.nan, FACES), "vertices", ValueError),
        (lambda: Object("snake"), "mesh", TypeError),
        (lambda: Object(Mesh(SQUARE, FACES), pigment=(2, 0, 0)), "colour", ValueError),
        (lambda: Object(Mesh(SQUARE, FACES), position=(2, 0)), "position", ValueError),
        (lambda: Scene([]), "object", ValueError),
        (lambda: Scene([3]), "objects", TypeError),
        (lambda: Scene("no-such-scene"), "no-such-scene", (ValueError, OSError)),
        (lambda: Scene("plate", lights=[30]), "lights", TypeError),
        (lambda: Scene("plate", lights=["bright"]), "bright", ValueError),
        (lambda: Scene("plate", camera=((0, 0, 0), (0, 0, 0), 30)), "camera", ValueError),
        (lambda: Light(np.nan, 0), "light", ValueError),
        (lambda: diffract.render("plate", 5), "surface", TypeError),
        (lambda: diffract.render("plate", "blaze", size=(0, 9)), "size", ValueError),
        (lambda: diffract.render("plate", "blaze", samples=0), "samples", ValueError),
    ],
)
def test_wrong_scenes_are_refused_by_name(make, name, kind):
    with pytest.raises(kind, match=name):
        make()

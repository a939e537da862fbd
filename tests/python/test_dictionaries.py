"""Scenes of dictionaries, and what can be changed of a scene."""

import re

import numpy as np
import pytest

import etendue as et

T = et.ScalarTransform4f
EYE = T.look_at(origin=[0, 1, 6], target=[0, 1, 0], up=[0, 1, 0])


def room(**more):
    """A ball on a floor under a lamp, 24 x 16 pixels; `more` replaces objects, None leaves them out."""
    objects = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 5},
        "sensor": {
            "type": "perspective",
            "fov": 40,
            "to_world": EYE,
            "film": {"type": "hdrfilm", "width": 24, "height": 16, "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": 4},
        },
        "white": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.8, 0.7, 0.6]}},
        "ball": {"type": "sphere", "center": [0, 1, 0], "radius": 1, "bsdf": {"type": "ref", "id": "white"}},
        "floor": {
            "type": "rectangle",
            "to_world": T().rotate([1, 0, 0], -90).scale(5),
            "bsdf": {"type": "roughconductor", "material": "Cu", "alpha": 0.2},
        },
        "lamp": {
            "type": "rectangle",
            "to_world": T().translate([0, 4, 0]).rotate([1, 0, 0], 90),
            "emitter": {"type": "area", "radiance": {"type": "spectrum", "value": [(400, 5.0), (600, 7.0), (700, 6.0)]}},
        },
        "sky": {"type": "constant", "radiance": 0.1},
    }
    return {name: value for name, value in {**objects, **more}.items() if value is not None}


ROOM = """<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="5"/></integrator>
  <sensor type="perspective">
    <float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="0,1,6" target="0,1,0" up="0,1,0"/></transform>
    <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/><rfilter type="box"/></film>
    <sampler type="independent"><integer name="sample_count" value="4"/></sampler>
  </sensor>
  <bsdf type="diffuse" id="white"><rgb name="reflectance" value="0.8, 0.7, 0.6"/></bsdf>
  <shape type="sphere"><point name="center" value="0,1,0"/><float name="radius" value="1"/><ref id="white"/></shape>
  <shape type="rectangle">
    <transform name="to_world"><scale value="5"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="roughconductor"><string name="material" value="Cu"/><float name="alpha" value="0.2"/></bsdf>
  </shape>
  <shape type="rectangle">
    <transform name="to_world"><rotate x="1" angle="90"/><translate y="4"/></transform>
    <emitter type="area"><spectrum name="radiance" value="400:5, 600:7, 700:6"/></emitter>
  </shape>
  <emitter type="constant"><float name="radiance" value="0.1"/></emitter>
</scene>
"""


def test_a_dictionary_is_the_scene_of_its_file(tmp_path):
    (tmp_path / "room.xml").write_text(ROOM)
    read, made = et.load_file(tmp_path / "room.xml"), et.load_dict(room())
    assert (made.size, made.spp, made.problems) == ((24, 16), 4, [])
    # Matrices of rotations differ in the last bit, so that the scenes do, too.
    pictures = [et.render(scene, device="reference").mean for scene in (made, read)]
    assert np.median(np.abs(pictures[0] - pictures[1]) / (1e-3 + pictures[1])) < 1e-9
    (tmp_path / "ball.xml").write_text(re.sub('(?s)<shape type="rectangle">.*?</shape>', "", ROOM))
    assert et.load_dict(room(floor=None, lamp=None)).hash == et.load_file(tmp_path / "ball.xml").hash


def test_meshes_of_arrays(tmp_path):
    positions = np.array([[-1, 0, 0], [1, 0, 0], [0, 2, 0]], np.float32)
    (tmp_path / "triangle.obj").write_text("v -1 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n")
    arrays = {"type": "mesh", "positions": positions, "triangles": [[0, 1, 2]]}
    file = {"type": "obj", "filename": tmp_path / "triangle.obj", "face_normals": True}
    assert et.load_dict(room(ball=arrays)).hash == et.load_dict(room(ball=file)).hash
    smooth = et.load_dict(room(ball={**arrays, "face_normals": False}))
    assert np.allclose(smooth.parameters["instances.ball.normals"], [0, 0, 1])
    given = et.load_dict(room(ball={**arrays, "normals": [[0, 0, 2], [0, 3, 0], [1, 0, 0]]}))
    assert np.array_equal(given.parameters["instances.ball.normals"], [[0, 0, 1], [0, 1, 0], [1, 0, 0]])


def test_pictures_of_arrays(tmp_path):
    texels = np.random.default_rng(1).random((4, 8, 3), np.float32)
    et.Image.from_arrays(texels).write(tmp_path / "texels.exr")

    def sky(**source):
        return et.load_dict(room(sky={"type": "envmap", **source}))

    def floor(**source):
        return et.load_dict(room(floor={"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": {"type": "bitmap", **source}}}))

    assert sky(bitmap=texels).hash == sky(filename=tmp_path / "texels.exr").hash
    assert floor(bitmap=texels).hash == floor(filename=tmp_path / "texels.exr").hash
    codes = np.full((2, 2, 3), 188, np.uint8)  # 188 is the code of 0.503 in sRGB
    assert floor(data=codes).hash != floor(data=codes, raw=True).hash


def test_errors_name_the_place():
    def complaint(**more):
        with pytest.raises((et.SceneError, et.UsageError)) as caught:
            et.load_dict(room(**more))
        return caught.value

    assert complaint(ball={"type": "spere"}).file == "dict:/ball"
    assert complaint(ball={"type": "sphere", "radius": -1}).file == "dict:/ball/radius"
    assert complaint(ball={"type": "sphere", "bsdf": {"type": "ref", "id": "whit"}}).file == "dict:/ball/bsdf"
    assert "did you mean" in str(complaint(ball={"type": "sphere", "bsdf": {"type": "ref", "id": "whit"}}))
    assert "shape hair (dict:/ball)" in str(complaint(ball={"type": "hair"}))
    assert "dict:/ball/center" in str(complaint(ball={"type": "sphere", "center": object()}))
    assert "dict:/ball/positions" in str(complaint(ball={"type": "mesh", "positions": [1, 2, 3], "triangles": [[0, 0, 0]]}))
    assert "the vertex 3; there are 1" in str(complaint(ball={"type": "mesh", "positions": [[1, 2, 3]], "triangles": [[0, 3, 0]]}))
    assert "integers" in str(complaint(ball={"type": "mesh", "positions": [[1, 2, 3]], "triangles": [[0, -1, 0]]}))
    itself = {"type": "twosided"}
    itself["inner"] = itself
    assert "contain itself" in str(complaint(ball={"type": "sphere", "bsdf": itself}))
    both = complaint(ball={"type": "sphere", "radius": -1}, lamp={"type": "sphere", "radius": -2})
    assert [problem.file for problem in both.problems] == ["dict:/ball/radius", "dict:/lamp/radius"]
    assert et.load_dict(room(ball={"type": "hair"}), approximate=True).approximations


def test_transforms():
    turned = T().translate([1, 2, 3]).rotate([0, 0, 1], 90)
    assert np.allclose(turned @ [1, 0, 0], [1, 3, 3])
    assert np.allclose(T.translate([1, 2, 3]).matrix, (T() @ T.translate([1, 2, 3])).matrix)
    assert np.allclose((turned @ turned.inverse()).matrix, np.eye(4))
    assert np.allclose(T.scale([1, 2, 3]) @ [1, 1, 1], [1, 2, 3])
    assert np.allclose(EYE @ [0, 0, 6], [0, 1, 0]) and np.allclose(EYE @ [1, 0, 0], [-1, 1, 6])
    for wrong in (lambda: T.rotate([0, 0, 0], 1), lambda: T.translate([1, 2]), lambda: T.look_at([0, 0, 0], [0, 1, 0], [0, 1, 0])):
        with pytest.raises(et.UsageError):
            wrong()


def test_parameters():
    scene = et.load_dict(room())
    changed = {
        "camera.fov": 50.0,
        "integrator.nee": False,
        "materials.white.albedo": (0.1, 0.2, 0.3),
        "materials.floor.bsdf.alpha_u": 0.5,
        "instances.ball.radius": 0.5,
        "instances.lamp.radiance": (1, 2, 3),
        "instances.lamp.to_world": T().translate([0, 3, 0]).rotate([1, 0, 0], 90),
    }
    for name, value in changed.items():
        scene.parameters[name] = value
        assert np.allclose(scene.parameters[name], getattr(value, "matrix", value)), name
    same = room()
    same["integrator"]["hide_emitters"] = False
    same["sensor"]["fov"] = 50
    same["white"]["reflectance"]["value"] = [0.1, 0.2, 0.3]
    same["floor"]["bsdf"] |= {"alpha_u": 0.5, "alpha_v": 0.2}
    del same["floor"]["bsdf"]["alpha"]
    same["ball"]["radius"] = 0.5
    same["lamp"]["emitter"]["radiance"] = {"type": "rgb", "value": [1, 2, 3]}
    same["lamp"]["to_world"] = T().translate([0, 3, 0]).rotate([1, 0, 0], 90)
    assert scene.hash == et.load_dict(same).hash
    scene.parameters["sky.top"] = 0.5
    assert np.array_equal(scene.parameters["sky.top"], [0.5, 0.5, 0.5])
    assert "materials.white.albedo" in scene.parameters and len(scene.parameters) == len(list(scene.parameters))


def test_wrong_parameters():
    scene = et.load_dict(room())
    with pytest.raises(KeyError, match="did you mean 'materials.white.albedo'"):
        scene.parameters["materials.white.albdo"] = 0.5
    for name, value in (("camera.fov", (1, 2)), ("integrator.nee", 2.5), ("camera.width", -1), ("materials.white.albedo", (1, 2)), ("instances.ball.to_world", np.eye(3))):
        before = scene.hash
        with pytest.raises(et.UsageError, match=name):
            scene.parameters[name] = value
        assert scene.hash == before
    scene.parameters["instances.ball.radius"] = -1.0
    with pytest.raises(et.SceneError, match="radius"):
        et.render(scene, spp=1)


def test_changes_are_rendered():
    """What is kept of an earlier render never hides a change."""
    scene = et.load_dict(room(floor={"type": "rectangle"}))  # diffuse alone: a kernel that is compiled quickly
    first = et.render(scene, spp=2)
    for name, value in (("materials.white.albedo", 0.1), ("camera.fov", 60.0), ("sky.top", 3.0), ("instances.ball.center", (1, 1, 0))):
        before = et.render(scene, spp=2)
        scene.parameters[name] = value
        after, fresh = et.render(scene, spp=2), et.render(scene.copy(), spp=2)
        assert not np.array_equal(after.mean, before.mean), name
        assert np.array_equal(after.mean, fresh.mean), name
    assert not np.array_equal(first.mean, et.render(scene, spp=2).mean)


def test_moved_vertices():
    scene = et.load_dict(room(ball={"type": "mesh", "positions": [[-1, 0, 0], [1, 0, 0], [0, 2, 0]], "triangles": [[0, 1, 2]]}))
    positions = scene.parameters["instances.ball.positions"]
    scene.parameters["instances.ball.positions"] = positions + [0, 0.5, 0]
    lifted = et.load_dict(room(ball={"type": "mesh", "positions": positions + [0, 0.5, 0], "triangles": [[0, 1, 2]]}))
    assert scene.hash == lifted.hash
    with pytest.raises(et.UsageError, match="as many rows"):
        scene.parameters["instances.ball.positions"] = positions[:2]


def test_words_of_notebooks_for_mitsuba(tmp_path):
    et.set_variant("llvm_ad_rgb")
    with pytest.raises(et.UsageError, match="scalar_spectral"):
        et.set_variant("scalar_spectral")
    parameters = et.traverse(et.load_dict(room()))
    parameters["materials.white.albedo"] = 0.5
    parameters.update()
    assert np.array_equal(parameters["materials.white.albedo"], [0.5, 0.5, 0.5])
    et.util.write_bitmap(tmp_path / "grey.exr", np.full((2, 3), 0.25))
    assert np.all(et.read_image(tmp_path / "grey.exr").mean == 0.25)

"""Claims that a scene file is the world, the run and the film that it says."""

from __future__ import annotations

import json
import tempfile
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from softbody.scenes import scene_file, scene_keys
from softbody.scenes.scene_file import SceneFile, _Reading, read_scene
from validation.answers import Answers
from validation.cases import random_orientations, rotation_matrix
from validation.check import Comparison, Run, check
from validation.checks.contract.exports import asked
from validation.fault import Fault

FAMILY = "what users set and ask"
LANE = "worlds"  # claims that share the kernels of a whole world, and a process

Rng = np.random.Generator
Table = dict[str, Any]
Parts = dict[str, np.ndarray]  # the vertices (6, 3) of each mesh file

KEYS: dict[str, Table] = {f"shape {name}": keys for name, keys in scene_keys.SHAPES.items()}  # that the core says
KEYS |= {"shape file": scene_keys.MESH_FILE, "world": scene_keys.WORLD, "ground": scene_keys.GROUND}
KEYS |= {"liquid": scene_keys.LIQUID}
KEYS |= {"soft_body": scene_keys.SOFT_BODY, "box": scene_keys.BOX, "joint": scene_keys.JOINT, "end": scene_keys.END}
KEYS |= {"suspension": scene_keys.SUSPENSION}
KEYS |= {"run": scene_keys.RUN, "film": scene_keys.FILM}
SINGLE, LISTS = ("world", "ground", "liquid", "run", "film"), ("soft_body", "box", "suspension", "joint")
OWN = {"gravity", "precision", "threads", "integrator", "substeps"}  # properties of a World; others are its settings
FIELDS = {  # of settings that are words for users: what the field is called, and which word makes it true
    **{"axes": ("paper_axes", "paper"), "contact": ("single_contact", "single")},
    **{"soft_contact": ("single_soft_contact", "single"), "pairs": ("exhaustive_pairs", "exhaustive")},
}
PAPER: Table = {"integrator": "rk4_velocity", "axes": "paper", "contact": "single", "soft_contact": "single"}
PAPER |= {"pairs": "exhaustive", "edge_contacts": False, "split_steps": False, "frictionless": True}
PAPER |= {"speed_ceiling": 10.0, "angular_speed_ceiling": 10.0, "angular_speed_floor": 0.2}

NOWHERE, UPRIGHT, INF = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], float("inf")
TOUCH: Table = {"restitution": 0.0, "friction": 0.5}
POSE: Table = {"name": None, "position": NOWHERE, "orientation": UPRIGHT, "velocity": NOWHERE}
USUAL: dict[str, Table] = {  # what the documentation says that is so where nothing is said
    "world": {"gravity": [0.0, 0.0, -9.81], "precision": "double", "threads": 1, "integrator": "symplectic_euler"}
    | {"substeps": 1, "axes": "complete", "contact": "manifold", "iterations": 30, "soft_contact": "together"}
    | {"pairs": "grid", "edge_contacts": True, "split_steps": True, "gyroscopic": False, "speed_ceiling": INF}
    | {"angular_speed_ceiling": INF, "angular_speed_floor": 0.0, "frictionless": False, "self_contact": False}
    | {"sleep_speed": 0.0, "sleep_after": 0.5, "paper": False},
    "ground": {"height": 0.0, **TOUCH},
    "liquid": {"density": 1000.0, "surface_height": 0.0, "drag": 0.0, "velocity": NOWHERE},
    "soft_body": {**POSE, **TOUCH, "fixed": [], "fixed_above": INF, "fixed_below": -INF, "drag": 0.0}
    | {"tear_at": 0.0, "leak": 200.0}
    | {"deflated_below": 0.0, "liquid_density": 0.0, "sound_speed": 0.0, "liquid_drag": 0.0, "self_contact": False},
    "box": {**POSE, **TOUCH, "mass": None, "kinematic": False, "angular_velocity": NOWHERE, "inside": None},
    "suspension": {"name": None, "weights": "mean-value", "box": None, "points": None},
    "joint": {"name": None, "damping": 0.0, "rest_length": 0.0},
    "run": {"frames_per_second": 60.0, "time_step": None, "velocities": True},
    "film": {"file": "film.webp", "frames_per_second": 20.0, "colour": "stripes", "colour_range": None}
    | {"size": [640, 480], "show_joints": True},
}

# What values are drawn from, see `drawn`: one of a list, a number from (low, high), as many as a third one says.
YES_OR_NO, LENGTH, VECTOR = [True, False], (1.0, 1.5), (-3.0, 3.0, 3)
TURNS = [lambda rng: random_orientations(rng, 1)[0].tolist(), {"axis": VECTOR, "degrees": (-400.0, 400.0)}]
TOUCHING: Table = {"restitution": (0.1, 1.0), "friction": (0.6, 2.0)}
POSED: Table = {"name": lambda rng: f"n° {rng.integers(10**9)}", "position": VECTOR, "orientation": TURNS}
POSED |= {"velocity": VECTOR}
DRAWS: dict[str, Table] = {
    "world": {"gravity": VECTOR, "precision": ["double", "single"], "threads": (1, 2), "paper": YES_OR_NO}
    | {"integrator": ["symplectic_euler", "rk4", "rk4_velocity"], "substeps": (1, 9), "axes": ["complete", "paper"]}
    | {"contact": ["manifold", "single"], "soft_contact": ["together", "single"], "pairs": ["grid", "exhaustive"]}
    | dict.fromkeys(("edge_contacts", "split_steps", "gyroscopic", "frictionless", "self_contact"), YES_OR_NO)
    | {key: [LENGTH, INF] for key in ("speed_ceiling", "angular_speed_ceiling")}
    | {"iterations": (1, 99), "angular_speed_floor": LENGTH, "sleep_speed": LENGTH, "sleep_after": LENGTH},
    "ground": {"height": (-9.0, -5.0), **TOUCHING},
    "liquid": {"density": LENGTH, "surface_height": VECTOR[:2], "drag": LENGTH, "velocity": VECTOR},
    "shape icosphere": {"subdivisions": (0, 2), "radius": LENGTH},
    "shape torus": {"major_radius": LENGTH, "minor_radius": (0.45, 0.6)}
    | {"major_segments": (12, 16), "minor_segments": (5, 9)},
    "shape box": {"size": (1.0, 2.0, 3), "segments": (2, 3)},
    **{f"shape {name}": {"radius": LENGTH} for name in ("tetrahedron", "octahedron", "icosahedron")},
    "shape file": {"file": "other.off", "merge": True, "tolerance": (2e-4, 3e-4), "scale": (2.0, 3.0)},
    "soft_body": {**POSED, **TOUCHING, "shape": {"file": "other.off"}, "mass": LENGTH, "gas": LENGTH}
    | {"pressure": LENGTH}
    | {"damping": LENGTH, "drag": LENGTH, "stiffness": [(100.0, 200.0), (100.0, 200.0, 12)]}
    | {"rest_length": [LENGTH, (1.0, 1.5, 12)], "fixed": lambda rng: rng.permutation(6)[:2].tolist()}
    | {"fixed_above": (0.1, 0.3), "fixed_below": (-0.3, -0.1), "deflated_below": (0.1, 0.9)}
    | {"liquid_density": LENGTH, "sound_speed": LENGTH, "liquid_drag": LENGTH, "leak": LENGTH}
    | {"tear_at": [LENGTH, (1.1, 1.5, 12)]}
    | {"self_contact": [True, False, (1e-4, 9e-4)]},
    "box": {**POSED, **TOUCHING, "size": (1.0, 2.0, 3), "mass": LENGTH, "static": True, "kinematic": True}
    | {"angular_velocity": VECTOR, "inside": (0, 1)},
    "suspension": {"name": POSED["name"], "soft_body": 1, "box": (0, 1), "points": [[[0.1, 0.0, 0.0], [0.0, 0.2, 0.1]]]}
    | {"stiffness": LENGTH, "damping": LENGTH, "weights": "tetrahedron"},
    "joint": {"name": POSED["name"], "a": VECTOR, "b": {"box": 1, "at": VECTOR}, "stiffness": LENGTH}
    | {"damping": LENGTH, "rest_length": LENGTH},
    "end": {"soft_body": 1, "box": 1, "suspension": 1, "at": VECTOR, "particle": (1, 5), "point": 1},
    "run": {"seconds": LENGTH, "frames_per_second": LENGTH, "time_step": (1e-5, 1e-4), "velocities": YES_OR_NO},
    "film": {"file": ["a.mp4", "b.webp"], "frames_per_second": LENGTH, "show_joints": YES_OR_NO}
    | {
        "colour": ["plain", "pressure", "strain", "speed"],
        "colour_range": lambda rng: sorted(rng.random(2).tolist()),
        "size": [[16, 99], [77, 32]],
    },
}
GOOD: dict[str, Table] = {  # what each table needs; joints end in the middle of a box, which no turn moves
    **{"world": {}, "ground": {}, "liquid": {}, "film": {}, "run": {"seconds": 1.0}},
    "soft_body": {"shape": {"file": "whole.off"}, "mass": 1.0, "stiffness": 100.0, "gas": 1.0},
    "box": {"size": [1.0, 1.0, 1.0], "mass": 1.0},
    "suspension": {"soft_body": 0, "points": [[0.1, 0.2, 0.3], [-0.1, 0.2, 0.4]]},
    "joint": {"a": [0.0, 0.0, 3.0], "b": {"box": 0, "at": NOWHERE}, "stiffness": 1.0},
}
WITH: dict[str, Table] = {  # what else is said where a key is
    **{"film colour": {"colour_range": [0.0, 1.0]}, "box kinematic": {"velocity": [1.0, 0.0, 0.0]}},
    **{"shape file merge": {"file": "soup.off"}, "shape file tolerance": {"file": "loose.off"}},
    **{"shape file scale": {"file": "whole.off"}, "end soft_body": {"particle": 3}, "end at": {"box": 0}},
    **{"end box": {"at": [0.5, 0.0, 1.0]}, "end particle": {"soft_body": 0}},
    **{"box inside": {"size": [0.1, 0.1, 0.1]}, "end suspension": {"point": 1}, "end point": {"suspension": 0}},
    **{f"suspension {key}": {"box": 1} for key in ("stiffness", "damping")},
    **{"soft_body liquid_density": {"damping": 0.5}},  # which by default is by its mass, too
}
SKINS = np.array([(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)])
SHIFTS = {"soft_body": np.array([1.0, 0.0, 0.0]), "box": np.array([0.0, 1.0, 0.0])}  # [m], times 1 + a body's number


def drawn(what: Any, rng: Rng) -> Any:
    """Draw a value, or all of a table."""
    if isinstance(what, dict):
        return {key: drawn(each, rng) for key, each in what.items()}
    if isinstance(what, list):
        one = what[rng.integers(len(what))]
        return one if isinstance(one, list) else drawn(one, rng)
    if isinstance(what, tuple):
        low, high, *shape = what
        return (rng.integers(low, high + 1) if isinstance(low, int) else rng.uniform(low, high, shape)).tolist()
    return what(rng) if callable(what) else what


def written_parts(folder: Path, rng: Rng) -> Parts:
    """Write mesh files of octahedra of six radii into a folder; return the vertices (6, 3) of each."""
    from references import trimesh

    parts = {}
    for name, off in {"whole": None, "other": None, "soup": 0.0, "loose": 4e-5}.items():
        x = rng.uniform(1.0, 1.4, (6, 1)) * np.kron(np.eye(3), [[1.0], [-1.0]])
        corners, triangles = x, SKINS
        if off is not None:  # triangles that share no vertices
            corners, triangles = x[SKINS.ravel()] + rng.uniform(-off, off, (24, 3)), np.arange(24).reshape(8, 3)
            x = corners[np.unique(SKINS, return_index=True)[1]]
        trimesh.write_mesh(folder / f"{name}.off", corners, triangles, True)
        parts[f"{name}.off"] = x
    return parts


def vertices_of(shape: Table, parts: Parts) -> np.ndarray:
    """Return the vertices (n, 3) [m] of a shape."""
    from references import trimesh

    name, radius = shape.get("name"), shape.get("radius", 1.0)
    if name == "torus":
        counts = shape.get("major_segments", 48), shape.get("minor_segments", 24)
        u, v = (angle.ravel() for angle in np.meshgrid(*(2.0 * np.pi * np.arange(k) / k for k in counts)))
        near = shape.get("minor_radius", 0.4)
        rho = shape.get("major_radius", 1.0) + near * np.cos(v)
        return np.stack([rho * np.cos(u), rho * np.sin(u), near * np.sin(v)], axis=1)
    if name == "box":
        side = np.linspace(-0.5, 0.5, shape.get("segments", 1) + 1)
        grid = np.array(list(product(side, side, side)))
        return shape.get("size", np.ones(3)) * grid[np.abs(grid).max(axis=1) == 0.5]
    if name in ("icosphere", "icosahedron"):
        return trimesh.icosphere(0 if name == "icosahedron" else shape.get("subdivisions", 3), radius)[0]
    if name == "tetrahedron":
        return radius / np.sqrt(3.0) * np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)])
    return radius * np.kron(np.eye(3), [[1.0], [-1.0]]) if name else shape.get("scale", 1.0) * parts[shape["file"]]


def turn_of(given: Any) -> np.ndarray:
    """Return the quaternion (4,) of an orientation."""
    if not isinstance(given, dict):
        return np.array(given)
    half, axis = 0.5 * np.deg2rad(given["degrees"]), np.array(given["axis"])
    return np.append(np.cos(half), np.sin(half) * axis / np.linalg.norm(axis))


def placed(body: Table, parts: Parts) -> np.ndarray:
    """Return where the vertices (n, 3) [m] of a soft body are."""
    matrix = rotation_matrix(turn_of(body.get("orientation", UPRIGHT)))
    return vertices_of(body["shape"], parts) @ matrix.T + body.get("position", NOWHERE)


def in_order(x: np.ndarray) -> np.ndarray:
    """Return the order (n,) of points by their coordinates."""
    return np.lexsort(np.round(x, 9).T)


def number_of(which: Any, scene: Table) -> int:
    """Return the number of a soft body that is named, or numbered."""
    return [body.get("name") for body in scene["soft_body"]].index(which) if isinstance(which, str) else int(which)


def end_of(end: Any, scene: Table, parts: Parts) -> np.ndarray:
    """Return where an end of a joint is, and by how much it moves with its body (2, 3) [m]."""
    if isinstance(end, list):
        return np.array([end, NOWHERE])
    if "suspension" in end:
        names = [each.get("name") for each in scene["suspension"]]
        hung = scene["suspension"][
            names.index(end["suspension"]) if isinstance(end["suspension"], str) else end["suspension"]
        ]
        return np.array([hung["points"][end["point"]], (number_of(hung["soft_body"], scene) + 1) * SHIFTS["soft_body"]])
    kind = "box" if "box" in end else "soft_body"
    names = [body.get("name") for body in scene[kind]]
    number = names.index(end[kind]) if isinstance(end[kind], str) else end[kind]
    place = end["at"] if "at" in end else placed(scene[kind][number], parts)[end["particle"]]
    return np.array([place, (number + 1) * SHIFTS[kind]])


def judged(scene: Table, parts: Parts) -> Table:
    """Return what a scene is said to be: by table, number and key."""
    given = scene.get("world", {})
    world = USUAL["world"] | (PAPER if given.get("paper") else {}) | given
    slippery = {"friction": 0.0} if world["frictionless"] else {}
    rows = {"world": world | {key: world[key] == word for key, (_, word) in FIELDS.items()}}
    rows |= {table: USUAL[table] | scene[table] for table in SINGLE[1:] if table in scene}
    rows |= {"ground": rows["ground"] | slippery} if "ground" in rows else {}
    for k, body in enumerate(scene["soft_body"]):
        one = USUAL["soft_body"] | {"self_contact": world["self_contact"]} | body | slippery
        x = placed(body, parts)
        held = (x[:, 2] > one["fixed_above"]) | (x[:, 2] < one["fixed_below"])
        held[one["fixed"]] = True
        order, is_torus = in_order(x), body["shape"].get("name") == "torus"
        springs = 3 * len(x) - (0 if is_torus else 6)
        damping = 0.1 * np.sqrt(2.0 * np.mean(one["stiffness"]) * one["mass"] / len(x))
        one.setdefault("damping", 0.0 if world["integrator"] == "rk4_velocity" else damping)
        one |= {key: np.broadcast_to(one.get(key, 0.0), springs) for key in ("stiffness", "rest_length", "tear_at")}
        one |= {"position": x[order], "fixed": held[order], "velocity": np.outer(~held[order], one["velocity"])}
        rows[f"soft_body[{k}]"] = {key: one[key] for key in one if key != "orientation"}
    for k, box in enumerate(scene["box"]):
        turn = {"orientation": turn_of(box.get("orientation", UPRIGHT))}
        rows[f"box[{k}]"] = USUAL["box"] | box | slippery | turn
        if "inside" in box:
            rows[f"box[{k}]"]["inside"] = number_of(box["inside"], scene)
    for k, hung in enumerate(scene["suspension"]):
        if "box" in hung:
            rows[f"box[{hung['box']}]"]["inside"] = number_of(hung["soft_body"], scene)
        rows[f"suspension[{k}]"] = USUAL["suspension"] | hung | {"soft_body": number_of(hung["soft_body"], scene)}
    for k, joint in enumerate(scene["joint"]):
        ends = np.stack([end_of(joint[end], scene, parts) for end in "ab"])
        rows[f"joint[{k}]"] = {"ends": ends} | USUAL["joint"] | joint
    hidden = {"paper", "shape", "static", "fixed_above", "fixed_below", "a", "b"}  # that are seen by what they do
    return {f"{table}.{key}": row[key] for table, row in rows.items() for key in row if key not in hidden}


def told(found: SceneFile, scene: Table) -> Table:
    """Return what the core says that a scene is, as its users would ask; its bodies are then moved."""
    world, settings = found.world, USUAL["world"].keys() - OWN - {"paper"}
    rows = {"world": {key: getattr(world.store.settings, FIELDS.get(key, (key,))[0]) for key in settings}}
    rows["world"] |= {key: getattr(world, key) for key in OWN}
    for table, what in (("ground", world.ground), ("liquid", world.liquid)):
        if what.is_there:
            rows[table] = {key: getattr(what, key) for key in USUAL[table]}
    rows |= {name: of._asdict() for name, of in (("run", found.run), ("film", found.film)) if of is not None}
    joints = world.joints[len(world.joints) - len(scene["joint"]) :]  # those by which boxes hang come first
    before = [joint.ends for joint in joints]
    for k, (hung, given) in enumerate(zip(world.suspended, scene["suspension"])):
        weights, is_box = hung.weights[0], hung.box is not None
        alike = np.isclose(weights[:, None], weights, rtol=0.0).sum(axis=0).max()
        told_of: Table = {"name": hung.name, "soft_body": hung.body.index, "points": None if is_box else hung.positions}
        told_of |= {"box": hung.box.index if hung.box is not None else None}
        told_of |= {key: getattr(world.joints[0], key) for key in ("stiffness", "damping") if key in given}
        rows[f"suspension[{k}]"] = told_of | {"weights": "tetrahedron" if 2 * alike >= len(weights) else "mean-value"}
    for k, (body, given) in enumerate(zip(world.soft_bodies, scene["soft_body"])):
        numbers = ["mass", "gas", "stiffness", "damping", "drag", "deflated_below", "self_contact"]
        numbers += ["liquid_density", "sound_speed", "liquid_drag", "leak", "tear_at"]
        order, one = in_order(body.positions), {key: getattr(body, key) for key in ("name", *TOUCH, *numbers)}
        one["mass"] -= body.liquid_density * body.volume
        if "pressure" in given:
            one["pressure"] = body.pressure
            del one["gas"]
        one |= {"rest_length": body.rest_length if "rest_length" in given else body.strain}
        one |= {"position": body.positions[order], "velocity": body.velocities[order]}
        rows[f"soft_body[{k}]"] = one | {"fixed": np.isin(np.arange(len(order)), body.fixed)[order]}
        body.positions = body.positions + (k + 1) * SHIFTS["soft_body"]
    for k, box in enumerate(world.boxes):
        one = {key: np.copy(getattr(box, key)) for key in (*POSE, *TOUCH, "size", "mass", "angular_velocity")}
        host = None if box.inside is None else box.inside.index
        rows[f"box[{k}]"] = one | {"kinematic": box.is_kinematic, "inside": host}
        box.position = box.position + (k + 1) * SHIFTS["box"]
    for k, joint in enumerate(joints):
        one = {key: getattr(joint, key) for key in ("name", "stiffness", "damping", "rest_length")}
        rows[f"joint[{k}]"] = one | {"ends": np.stack([before[k], joint.ends - before[k]], axis=1)}
    return {f"{table}.{key}": value for table, row in rows.items() for key, value in row.items()}


def same(found: Table, judged: Table, name: str) -> bool:
    """Tell whether an answer is the one that is judged right: numbers but for rounding."""
    if name not in found or isinstance(judged[name], bool):  # a length that is any is said to be so
        return name in found and bool(found[name]) is judged[name]
    ours, theirs = np.asarray(found[name]), np.asarray(judged[name])
    if ours.dtype.kind in "fiu" and theirs.dtype.kind in "fiu":
        return ours.shape == theirs.shape and np.allclose(ours, theirs, 1e-12, 1e-12)
    return np.array_equal(ours, theirs)


def agree(found: Table, judged: Table) -> bool:
    """Tell whether all answers are those that are judged right, and there are no others."""
    return found.keys() == judged.keys() and all(same(found, judged, name) for name in judged)


def put(table: str, given: Table) -> tuple[str, Table, str]:
    """Return which table of a file some keys are in, all that is in it, and the key that they are nested in."""
    if table.startswith("shape "):
        named = {} if table == "shape file" else {"name": table.removeprefix("shape ")}
        return "soft_body", GOOD["soft_body"] | {"shape": named | given}, "shape"
    return ("joint", GOOD["joint"] | {"a": given}, "a") if table == "end" else (table, GOOD[table] | given, "")


def alone(table: str, key: str, rng: Rng) -> Table:
    """Return a scene in which a key has another value than by default, for one of two bodies or joints."""
    scene: Table = {each: [GOOD[each], GOOD[each]] for each in LISTS}
    while (value := drawn(DRAWS[table][key], rng)) == USUAL.get(table, {}).get(key):
        pass
    where, content, _ = put(table, WITH.get(f"{table} {key}", {}) | {key: value})
    if key in ("static", "kinematic"):
        del content["mass"]
    if key == "pressure":
        del content["gas"]
    if where in SINGLE:
        return scene | {where: content}
    if "box" in content and where == "suspension":
        del content["points"]
        scene["box"] = [GOOD["box"] | {"size": [0.2, 0.1, 0.1], "position": [0.05, 0.1, 0.0]}] * 2
    # (Points hang in the first body, which has room for them.)
    scene[where][1 if where == "soft_body" else rng.integers(2)] = content
    return scene


def crowd(rng: Rng, parts: Parts) -> Table:
    """Return a scene in which every key is given, as far as they go together, and each body has its own."""
    scene: Table = {table: drawn(DRAWS[table], rng) for table in SINGLE} | {table: [] for table in LISTS}
    if rng.random() < 0.5:  # gravity is aslant, and a liquid is level
        del scene["liquid"]
    else:
        scene["world"]["gravity"] = [0.0, 0.0, rng.uniform(-9.0, -1.0)]
    scene["run"]["velocities"] |= scene["film"]["colour"] == "speed"
    never = {"self_contact": False} if scene["world"]["soft_contact"] == "single" else {}
    scene["world"] |= never
    shapes = [{"file": "whole.off"}, {"file": "other.off", "scale": 2.5}]
    shapes += [drawn(DRAWS["shape file"], rng) | {"file": name} for name in ("soup.off", "loose.off")]
    shapes += [{"name": name, **drawn(DRAWS[f"shape {name}"], rng)} for name in scene_keys.SHAPES]
    for k, shape in enumerate(shapes):
        body = drawn(DRAWS["soft_body"], rng) | {"shape": shape} | never
        del body["pressure" if k % 2 else "gas"]
        if "pressure" in body:  # which a liquid would add to
            del body["liquid_density"]
        if k >= 2:  # vertices and edges that nobody has numbered
            body |= {"fixed": [], "stiffness": 100.0 + k, "rest_length": 1.0 + k, "tear_at": 1.1 + k}
        z = np.sort(placed(body, parts)[:, 2])
        scene["soft_body"].append(body | {"fixed_above": float(z[-2:].mean()), "fixed_below": float(z[:2].mean())})
    for left_out in ("static kinematic", "mass static", "mass kinematic velocity angular_velocity"):
        box = drawn(DRAWS["box"], rng)
        del box["inside"]
        scene["box"].append({key: value for key, value in box.items() if key not in left_out.split()})
    for number in (0, 1, 0):
        hung, body = drawn(DRAWS["suspension"], rng), scene["soft_body"][number]
        places = placed(body, parts).mean(axis=0) + rng.uniform(-0.1, 0.1, (3, 3))
        which = drawn([number, body["name"]], rng)
        keys = {key: hung[key] for key in ("name", "weights")} | {"soft_body": which, "points": places.tolist()}
        scene["suspension"].append(keys)
    for _ in range(8):
        number, other = (int(rng.integers(count)) for count in (3, 2))
        box, body = scene["box"][number], scene["soft_body"][other]
        on_skin = rng.dirichlet(np.ones(3)) @ placed(body, parts)[SKINS[rng.integers(8)]]
        on_body = drawn([{"particle": (0, 5)}, {"at": [on_skin.tolist()]}], rng)
        on_body["soft_body"] = drawn([other, body["name"]], rng)
        hung = scene["suspension"][number]
        ends = [drawn({"box": [number, box["name"]], "at": VECTOR}, rng), on_body, drawn(VECTOR, rng)]
        ends += [drawn({"suspension": [number, hung["name"]], "point": (0, 2)}, rng)]
        first = int(rng.integers(4))
        scene["joint"].append(drawn(DRAWS["joint"], rng) | {"a": ends[first], "b": ends[first - 1]})
    return scene


def toml(value: Any) -> str:
    """Return a value as TOML has it."""
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {toml(each)}' for key, each in value.items())} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    return json.dumps(value) if isinstance(value, (bool, str)) else str(value)


def text_of(scene: Table) -> str:
    """Return a scene as a file has it."""
    rows = []
    for table, content in scene.items():
        for each in content if isinstance(content, list) else [content]:
            rows += [f"[[{table}]]" if isinstance(content, list) else f"[{table}]"]
            rows += [f"{key} = {toml(value)}" for key, value in each.items()]
    return "\n".join(rows)


def read(path: Path, scene: Table) -> Table:
    """Return what the core says of a scene that it reads."""
    path.write_text(text_of(scene))
    return told(read_scene(path), scene)


@check(
    section="beyond the paper",
    piece="softbody.scenes.from_file, softbody.scenes.scene_file.read_scene",
    reference="the documentation; what was written, with places of vertices by NumPy and trimesh",
    engines=("trimesh",),
    kind="specification",
    faults=(
        Fault("soft bodies that are not turned", _Reading._soft_body, "x_ @ rotation_matrix(q_).T → x_"),
        Fault("soft bodies turned the other way", _Reading._soft_body, "rotation_matrix(q_).T → rotation_matrix(q_)"),
        Fault("what is above, wherever its body is", _Reading._soft_body, "x_[:, 2] + z_ → x_[:, 2]"),
        Fault("fixed vertices that others displace", _Reading._soft_body, "[*fixed_, *held] → held or fixed_"),
        Fault("mesh files in their own units", _Reading._mesh_file, "mesh_.scaled(scale) → mesh_"),
        Fault("merging, however near", _Reading._mesh_file, "f_(path, **given) → f_(path, merge=bool(given))"),
        Fault("a paper's world without other settings", _Reading._world, "World.paper(**settings) → World.paper()"),
        Fault("a ground of which something is said", _Reading.scene, "ground is not None → ground"),
        Fault(
            "water that does not flow",
            _Reading.scene,
            "world_.add_liquid(**liquid_) → world.add_liquid(**{**liquid, 'velocity': np.zeros(3)})",
        ),
        Fault("joints of the first of a kind", _Reading._body, "a_ if b_ else (kind, which) → a_ if b_ else (kind, 0)"),
        Fault("joints with their ends exchanged", _Reading._joint, "('a', 'b') → ('b', 'a')"),
        Fault("no names of joints", _Reading._joint, "f_(*ends, **given) → f_(*ends, **{**given, 'name': None})"),
        Fault("boxes outside", _Reading._box, "f_(a_, b_, **given) → f_(a_, b_, **{**given, 'inside': None})"),
        Fault(
            "points in the first body",
            _Reading._suspension,
            "f_(what_, body_, **given) → f_(what, world.soft_bodies[0], **given)",
        ),
        Fault("boxes at rest", _Reading._box, "f_(a_, b_, **given) → f_(a_, b_, **{**given, 'velocity': np.zeros(3)})"),
        Fault("turned by twice the degrees", scene_keys._orientation, "0.5 * radians(d_) → radians(d_)"),
        Fault("every spring of a list as the first", scene_keys._springs, "return numbers → return numbers.ravel()[0]"),
        Fault("films as wide as high", scene_keys._pair, "check(value[1], n_) → check(value[0], n_)"),
        Fault("films of 25 frames a second", "softbody.scenes.scene_file.Film", "a_: float = 20.0 → a_: float = 25.0"),
    ),
)
def every_key_is_read(run: Run) -> Comparison:
    """Every key of a scene file sets what it says.

    Each key that there is, alone and beside all others that go with it. Each body has its own numbers, so that one at
    another body is seen, and what is not said is as by default. Joints are on their bodies: they move with them. A key
    that is new, or gone, is told.
    """
    rng, answers = run.fresh_rng(), Answers()
    answers.add({*scene_file.TABLES, *scene_file.LISTS} == {*SINGLE, *LISTS}, True, kind="the tables that there are")
    for table in dict.fromkeys([*KEYS, *DRAWS]):
        others = sorted(KEYS.get(table, {}).keys() ^ DRAWS.get(table, {}).keys())
        answers.add(not others, True, kind=f"{table}: {', '.join(others) or 'the keys that there are'}")
    with tempfile.TemporaryDirectory() as folder:
        path, parts = Path(folder) / "scene.toml", written_parts(Path(folder), rng)
        nothing: Table = {table: [GOOD[table], GOOD[table]] for table in LISTS}
        usual = judged(nothing, parts)
        for table in ("world", "ground", "liquid", "film"):
            scene = nothing | {table: {}}
            answers.add(agree(asked(read, {}, path, scene), judged(scene, parts)), True, kind=f"{table}, empty")
        for table, key in [(table, key) for table, keys in DRAWS.items() for key in keys] * run.count(1, 3, 20):
            scene = alone(table, key, rng)
            right = judged(scene, parts)
            is_read = agree(asked(read, {}, path, scene), right) and not agree(usual, right)
            answers.add(is_read, True, kind=f"{table}: {key}, alone")
        for _ in range(run.count(4, 12, 100)):
            scene = crowd(rng, parts)
            found, right = asked(read, {}, path, scene), judged(scene, parts)
            for name in right:
                answers.add(same(found, right, name), True, kind=f"{name}, with others")
    return answers.comparison()

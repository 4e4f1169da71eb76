"""SRDF: disabled pairs, joints of groups, values of named states."""

import xml.etree.ElementTree as tree


def result(pairs, groups, states):
    pairs = sorted({tuple(sorted(pair)) for pair in pairs}, key=lambda pair: str(list(pair)).replace("'", '"'))
    found = {"pairs": [list(pair) for pair in pairs]}
    if groups is not None:
        found["groups"] = {name: sorted(joints) for name, joints in groups.items() if joints}
    if states is not None:
        found["states"] = states
    return found


def urdf(file):
    return file.with_name("robot.urdf")


def pinocchio(file):
    """Pairs that are gone, and the joints of each reference configuration that are not at 0."""
    import pinocchio as pin

    model = pin.buildModelFromUrdf(str(urdf(file)))
    geometry = pin.buildGeomFromUrdf(model, str(urdf(file)), pin.GeometryType.COLLISION)
    geometry.addAllCollisionPairs()
    link = lambda i: model.frames[geometry.geometryObjects[i].parentFrame].name
    before = {(link(p.first), link(p.second)) for p in geometry.collisionPairs}
    pin.removeCollisionPairs(model, geometry, str(file), False)
    after = {(link(p.first), link(p.second)) for p in geometry.collisionPairs}
    return result(before - after, None, None)


def compas(file):
    from compas_fab.robots import RobotSemantics
    from compas_robots import RobotModel

    robot = RobotModel.from_urdf_file(str(urdf(file)))
    semantics = RobotSemantics.from_srdf_file(str(file), robot)
    movable = {j.name for j in robot.joints if j.type != j.FIXED}
    groups = {name: set(group["joints"]) & movable for name, group in semantics.groups.items()}
    numbers = lambda values: {joint: float(value) for joint, value in values.items()}
    states = {name: numbers(values) for of in semantics.group_states.values() for name, values in of.items()}
    return result(semantics.disabled_collisions, groups, states)


def tesseract(file):
    from tesseract_robotics import tesseract_common, tesseract_srdf, tesseract_urdf

    locator = tesseract_common.GeneralResourceLocator()
    graph = tesseract_urdf.parseURDFFile(str(urdf(file)), locator).release()
    model = tesseract_srdf.SRDFModel()
    model.initFile(graph, str(file), locator)
    pairs = [tuple(pair) for pair in model.acm.getAllAllowedCollisions().keys()]
    information = model.kinematics_information
    states = {}
    for group in information.group_states.keys():
        for name, values in information.group_states[group].items():
            states[name] = {joint: value for joint, value in values.items()}
    groups = {}
    for name, chains in information.chain_groups.items():
        groups[name] = {joint for base, tip in chains for joint in path(file, base, tip)}
    for name, joints in information.joint_groups.items():
        groups[name] = set(joints)
    return result(pairs, groups, states)


def path(file, base, tip):
    """Joints between two links, of which the one carries the other."""
    joints = {joint.find("child").get("link"): joint for joint in tree.parse(urdf(file)).getroot().findall("joint")}
    found, at = [], tip
    while at != base:
        found.append(joints[at].get("name"))
        at = joints[at].find("parent").get("link")
    return found


def ours(file):
    """What MoveIt's own words say of links that are off by default: such a link with every other."""
    if file.stem == "group_of_links":
        return {"groups": {"arm": ["j1", "j2", "j3"], "hand": ["g1", "g2"]}}
    if file.stem == "state_unknown_group":
        groups = {"arm": ["j1", "j2", "j3"], "hand": ["g1", "g2"]}
        return {"groups": groups, "states": {"home": {"j1": 0.5, "j2": -0.5, "j3": 1.0}}}
    if file.stem == "pair_without_link2":
        return result({("base", "l1"), ("l1", "l2")}, None, None)
    if file.stem not in ("default_off", "default_off_but_one"):
        raise ValueError("nothing is written down")
    links = [link.get("name") for link in tree.parse(urdf(file)).getroot().findall("link")]
    pairs = {("base", "l1"), ("l1", "l2")} | {tuple(sorted(("f1", link))) for link in links if link != "f1"}
    if file.stem == "default_off_but_one":
        pairs.discard(("base", "f1"))
    return result(pairs, None, None)


READERS = {"pinocchio-srdf": pinocchio, "tesseract": tesseract, "compas": compas, "ours": ours}

"""Who stands in traffic says why: `Agent.brakes_for`."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

import cadet
from cadet.worlds.districts import District

REASONS = {"vehicle", "obstacle", "person", "light", "junction", "road end"}


def test_who_has_driven_and_stands_names_a_reason_and_whom_it_waits_for() -> None:
    policy = replace(cadet.ResetPolicy.kitti(), districts=((District.named("main_road"), 1.0),))
    found: dict[str, int] = {}
    ahead = met = 0
    for seed in range(3):
        scene = cadet.Scene.random(seed=seed, policy=policy)
        stood_s: dict[int, int] = {}
        for _ in range(25):
            scene.step(1.0)
            agents = {agent.id: agent for agent in scene.agents}
            for agent in agents.values():
                if agent.speed_mps > 0.3:
                    stood_s[agent.id] = 0
                    continue
                # Parked, or on foot.
                if agent.id not in stood_s or agent.type in ("Pedestrian", "Person_sitting"):
                    continue
                stood_s[agent.id] += 1
                # Who begins to move has no reason any more.
                if stood_s[agent.id] < 3 or agent.speed_mps > 0.02:
                    continue
                assert agent.brakes_for in REASONS, f"seed {seed}: {agent} stands for {agent.brakes_for}"
                found[agent.brakes_for] = found.get(agent.brakes_for, 0) + 1
                # The last car of a tram is farther from what its driver waits for.
                if agent.brakes_for == "vehicle" and agent.type != "Tram":
                    met += 1
                    assert agent.brakes_for_id in {0, *agents}, f"seed {seed}: {agent} waits for {agent.brakes_for_id}"
                    if agent.brakes_for_id:
                        to_other = agents[agent.brakes_for_id].world_from_agent[:3, 3] - agent.world_from_agent[:3, 3]
                        is_near = math.hypot(*to_other[:2]) < 25.0
                        ahead += bool(is_near and np.dot(agent.world_from_agent[:3, 0], to_other) > 0.0)
                    else:
                        ahead += 1
    assert found.get("light", 0) >= 5, found
    assert met >= 10 and ahead == met, f"{ahead} of {met} wait for somebody ahead of them"

"""Other forms of observations and actions of the same environment."""

from regionslam_env.wrappers.discrete_actions import MOTIONS, DiscreteActions
from regionslam_env.wrappers.flat_observation import FlatObservation
from regionslam_env.wrappers.graph_observation import EdgeKind, GraphObservation
from regionslam_env.wrappers.semantic_actions import SemanticActions
from regionslam_env.wrappers.text_observation import TextObservation

__all__ = [
    "MOTIONS",
    "DiscreteActions",
    "EdgeKind",
    "FlatObservation",
    "GraphObservation",
    "SemanticActions",
    "TextObservation",
]

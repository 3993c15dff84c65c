"""What the robot is asked to do."""

from __future__ import annotations

from dataclasses import dataclass

from regionslam_env.errors import ConfigError


@dataclass(frozen=True)
class GoTo:
    """Be in any region of a type.

    Parameters
    ----------
    type
        Semantic type of the wanted region, a word of the environment's vocabulary.
    """

    type: str

    def __str__(self) -> str:
        return f"go to the {self.type}"


@dataclass(frozen=True)
class Explore:
    """Map the floor."""

    def __str__(self) -> str:
        return "map the floor"


@dataclass(frozen=True)
class Return:
    """Be back where the map was begun."""

    def __str__(self) -> str:
        return "return to the start"


Instruction = GoTo | Explore | Return


def goal_of(instruction: Instruction) -> str | None:
    """Return the semantic type that an instruction leads to, None where it leads to none."""
    return instruction.type if isinstance(instruction, GoTo) else None


@dataclass(frozen=True)
class Mission:
    """Instructions to follow in order.

    Parameters
    ----------
    instructions
        At least one.
    """

    instructions: tuple[Instruction, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.instructions, tuple) or not self.instructions:
            raise ConfigError(f"instructions is {self.instructions!r}, expected a tuple of at least one instruction")
        for part in self.instructions:
            if not isinstance(part, GoTo | Explore | Return):
                raise ConfigError(f"instruction {part!r}, expected a GoTo, an Explore or a Return")

    @property
    def types(self) -> tuple[str, ...]:
        """Semantic types that it leads to, each once."""
        return tuple(dict.fromkeys(filter(None, map(goal_of, self.instructions))))

    def now(self, completed: float) -> str:
        """Return in words which of several instructions is due once a share of them is done; nothing for a single one.

        Parameters
        ----------
        completed
            In [0, 1].
        """
        total = len(self.instructions)
        done = round(completed * total)
        return f"{self.instructions[done]} ({done + 1} of {total})" if done < total > 1 else ""

    def __str__(self) -> str:
        return ", then ".join(str(instruction) for instruction in self.instructions)

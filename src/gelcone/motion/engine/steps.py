"""Motions advanced step by step, with numbers that may be set in between."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from gelcone.codes import Outcome
from gelcone.motion.engine.interruptions import border_events
from gelcone.motion.engine.plan import ARRIVED, NOT_FINITE, TERMINAL_EVENT, TOO_MANY_STEPS
from gelcone.motion.engine.program import Program, Rerun
from gelcone.physics.driven import DrivenSystem
from gelcone.physics.trace import ordered
from gelcone.quantity import Array


class Steps(Rerun):
    """Motions of a system under inputs; each step continues from the states and switches of the one before.

    ``states`` (members, N), ``switches`` (members, switches), dimensionless ``lengths`` of a step and ``smallest_step``
    (members,) may be written between steps. Each step begins at time 0. The bits are those of a run of each member
    alone.

    Parameters
    ----------
    system : the system under inputs, without corners.
    tolerance : relative error of one step of the integrator.
    members : number of motions.
    most_steps : number of steps of the integrator after which a member ends.
    """

    def __init__(self, system: DrivenSystem, tolerance: float, members: int, most_steps: float) -> None:
        program = Program(system, "states", tolerance, border_events(system))
        super().__init__(program, np.zeros(members), np.ones(members), most_steps)
        arrays = self._arrays
        self.states, self.switches = arrays.states, arrays.switches
        self.lengths, self.smallest_step = arrays.times[:, 0], arrays.smallest
        self.switch_names = tuple(node.value for node in self._compiled.plan.switches)
        self._ending = system.film.ending
        self._own_borders = len(system.borders) - len(system.field_borders)
        self._rows = {name: row for row, name in enumerate(self.numbers)}
        self._alone = self._numbers_alone()
        self._stale = True

    def _numbers_alone(self) -> dict[str, int]:
        """Rows of numbers in the table of held values that no other held value depends on, by name."""
        held = self._compiled.layout.held
        parts = [{leaf.value for leaf in ordered([node]) if leaf.operation == "number"} for node in held]
        number_rows = {node.value: k for k, node in enumerate(held) if node.operation == "number"}
        return {name: row for name, row in number_rows.items() if sum(name in part for part in parts) == 1}

    def set(self, name: str, values: Array | float) -> None:
        """Set a number of all members, to one value or (members,)."""
        self._values[self._rows[name], : self._members] = values
        if name in self._alone and not self._stale:
            self._arrays.table[self._alone[name], : self._members] = values
        else:
            self._stale = True

    def set_all(self, values: Array, where: npt.NDArray[np.intp]) -> None:
        """Set all ``numbers`` (names, members) of the members with the indices ``where``."""
        self._values[:, where] = values
        self._stale = True

    def step(self) -> npt.NDArray[np.int8]:
        """Advance all members by their lengths, and return their outcomes. A member that failed stays at its end."""
        arrays = self._arrays
        if self._stale:
            self._compiled.prepare(*self._table)
            self._stale = False
        self._run_again()
        outcome = np.zeros(self._members, dtype=np.int8)
        arrays.states[:] = arrays.result[:, 0]
        ended = np.flatnonzero(arrays.status != ARRIVED)
        if ended.size:
            arrays.states[ended] = arrays.end_state[ended]
            status = arrays.status[ended]
            outcome[ended] = self._ending
            endless = (status == NOT_FINITE) & (arrays.smallest[ended] == 0.0)
            outcome[ended[endless]] = Outcome.NOT_FINITE
            outcome[ended[status == TOO_MANY_STEPS]] = Outcome.STEP_LIMIT
            outcome[ended[status >= TERMINAL_EVENT]] = Outcome.PULLED_IN
        return outcome

    @property
    def broke_down(self) -> npt.NDArray[np.bool_]:
        """Mask of members that ended in the last step because the true field reached the dielectric strength."""
        return self._arrays.status >= TERMINAL_EVENT + self._own_borders

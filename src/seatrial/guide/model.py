# SPDX-License-Identifier: MIT
"""The third step of a guided path: the model, with the effects that the recordings show and the user accepts."""

from collections.abc import Sequence

from seatrial.boat.findings import Finding
from seatrial.boat.model import Model
from seatrial.boat.model_file import load, save
from seatrial.boat.vehicle import Vehicle
from seatrial.guide.answers import AT_ORIGIN, effect_answered
from seatrial.guide.held_out import HELD_OUT_SHARE, HELD_OUT_SUFFIX
from seatrial.guide.steps import Task
from seatrial.identification.experiment_design.gain import drive_time
from seatrial.identification.guided import Guided, identify_guided
from seatrial.identification.selection.significance import enough_blocks, least_length, usable_time
from seatrial.recording.recording import Recording
from seatrial.util.format import joined
from seatrial.workflow.next_step import identify_line


def model_of(
    here: Task,
    training: Sequence[Recording],
    held_out: Sequence[Recording],
    vehicle: Vehicle,
    made_from: str,
) -> Model:
    """Identify, with the effects that the model lacks; or the model that is there."""
    path = here.file("model.yaml")
    if here.steps.done("model", made_from, [path]):
        here.say(f"identify  done before  -> {path}")
        return load(path)
    accepted: list[str] = []

    def confirm(kind: str, finding: Finding) -> bool:
        answer = here.ask is None or effect_answered(finding, here.ask)
        accepted.extend([kind] if answer else [])
        return answer

    found = identify_guided(training, vehicle, effects=here.effects, confirm=confirm)
    save(found.model, path)
    here.steps.note("model", made_from, [path])
    if here.ask is None:
        here.assumed += [
            f"{effect} is estimated with the model, because the log shows it"
            for effect in found.effects
        ]
    here.say(f"identify  {_made_of(found, training, held_out, vehicle, accepted)}  -> {path}")
    _lever_stated_wrong(here, found.model, vehicle)
    return found.model


def _made_of(
    found: Guided,
    training: Sequence[Recording],
    held_out: Sequence[Recording],
    vehicle: Vehicle,
    accepted: Sequence[str],
) -> str:
    """Coefficients, effects, and effects that were accepted and are not in the model."""
    text = f"{len(found.model.values)} coefficients"
    if found.choice.selection is not None:
        text += ", terms chosen by the recordings"
    elif vehicle.automatic:
        short = (
            "models with chosen terms diverge"
            if found.choice.diverges
            else too_short_text(found, training, held_out)
        )
        text += f", those that every boat has: {short}"
    dropped = [kind for kind in accepted if kind not in found.effects]
    text += f"; with {joined(found.effects)}" if found.effects else ""
    return text + (
        f"; without {joined(dropped)}: effects and terms of the model explain it" if dropped else ""
    )


def too_short_text(
    found: Guided, training: Sequence[Recording], held_out: Sequence[Recording]
) -> str:
    """What identifies and what choosing terms takes, in s, and how to get there."""
    used = usable_time(training)
    parameters = len(found.solution.problem.free)
    if enough_blocks(training, parameters):  # candidates are further parameters
        return f"the recordings ask for more terms than {used:.0f} s tell apart: record longer"
    least = least_length(training, parameters)
    # the last quarter of what is recorded further is held out, too
    quarters = any(one.name.endswith(HELD_OUT_SUFFIX) for one in held_out)
    lacking = (least - used) / ((1.0 - HELD_OUT_SHARE) if quarters else 1.0)
    whole = used + usable_time(held_out)
    other = ", or give another drive with --test" if quarters and whole >= least else ""
    return (
        f"{used:.0f} s identify the model, choosing terms takes {least:.0f} s: record {drive_time(lacking)} "
        f"more{other}"
    )


def _lever_stated_wrong(here: Task, model: Model, vehicle: Vehicle) -> None:
    """State that the lever arm is the log's: the user's, or the origin, does not stand."""
    if model.vehicle.lever == vehicle.lever:
        return
    here.assumed[:] = [one for one in here.assumed if one != AT_ORIGIN]
    if vehicle.stated_lever is not None and any(vehicle.lever):
        here.assumed.append(
            f"the lever arm stated, {vehicle.point}, does not fit the log; it shows {model.vehicle.point}"
        )


def whole_command(here: Task, model: Model, held_out: Sequence[Recording]) -> str | None:
    """State the command that identifies from the last quarters, too; None where none is held out."""
    if not any(one.name.endswith(HELD_OUT_SUFFIX) for one in held_out):
        return None
    whole = identify_line(
        here.again(*here.logs),
        here.file("vehicle.yaml"),
        here.file("model-of-all.yaml"),
        *effect_options(model),
    )
    here.assumed.append(
        f"what tests the model is not used to identify it. A model of all the data: {whole}"
    )
    return whole


def effect_options(model: Model) -> list[str]:
    """Options of `identify` with the model's effects."""
    effects = str(model.estimator.settings.get("effects") or "").split(", ")
    return [word for effect in effects if effect for word in ("--effect", effect)]

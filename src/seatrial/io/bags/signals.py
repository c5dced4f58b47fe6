# SPDX-License-Identifier: MIT
"""Signals of a bag: fields of messages, or transforms."""

from collections.abc import Mapping, Sequence

import numpy as np

from seatrial.boat.schema import Column, PoseSource
from seatrial.boat.vehicle import Vehicle
from seatrial.io.bags.bag import Bag
from seatrial.io.bags.collect import Collector, Samples, collect
from seatrial.io.bags.pauses import pause_remarks, pauses, with_unknown_commands
from seatrial.io.bags.poses import chosen_stamps, of_one_frame, usual_columns
from seatrial.io.bags.tf import FRAME_FIELDS, is_tf, tf_pose
from seatrial.io.signals import Request, Rows, Signals, Spec, given_rows, of_columns, shared_places
from seatrial.recording.timing import Clock, describe
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Mask
from seatrial.util.progress import stage
from seatrial.util.quaternion import yaw

ALL_READ, COMMANDS_READ = 0.9, 0.3  # of the time of a recording; poses from tf are read apart


class BagSignals(Signals):
    """Topics of an open bag."""

    def __init__(self, bag: Bag, vehicle: Vehicle) -> None:
        self.path, self.files = bag.path, bag.files
        self._bag, self._vehicle = bag, vehicle

    def pose_columns(self, vehicle: Vehicle) -> Mapping[str, Column]:
        """Columns x, y and psi, those of the usual messages where the file names none."""
        return usual_columns(self._bag, vehicle)

    def place(self, column: Column, spec: Spec, where: str) -> str:
        """The column's topic."""
        source, _, key = where.partition(": ")
        topic = column.topic or spec.topic
        pose = isinstance(spec, PoseSource)
        if topic is not None and pose and is_tf(found := self._bag.topic(topic, "pose: topic")):
            return found.name
        if topic is None or not (column.field or column.quaternion):
            lacks = "topic" if topic is None else "field"
            what = "pose:" if pose and topic is None else f"{key} has"
            raise RecordingError(
                f"{source}: {what} no {lacks}; name one for bags, or let 'seatrial init {self.path}' "
                "write a vehicle file"
            )
        return self._bag.topic(topic, "pose: topic" if pose and not column.topic else key).name

    def read(self, requests: Sequence[Request]) -> list[Rows]:
        """The rows of each request, in one pass; transforms in one of their own."""
        shared = shared_places(requests)
        turned = [self._is_transforms(one) for one in requests]
        plain = [one for one, is_turned in zip(requests, turned, strict=True) if not is_turned]
        wanted = [self._collector(one) for one in plain]
        with stage("", COMMANDS_READ if any(turned) else ALL_READ):
            samples = collect(self._bag, wanted)
        lost = [f"{s.dropped} unreadable messages on {s.topic.name}" for s in samples if s.dropped]
        self._pauses = pauses(self._bag)
        self.remarks = (*self._bag.remarks, *lost, *pause_remarks(self._bag, self._pauses))
        # removed from the list one by one, so that ten hours of samples are in memory once
        return [
            self._from_transforms(one)
            if is_turned
            else self._from_samples(one, samples.pop(0), mixed=one.place in shared)
            for one, is_turned in zip(requests, turned, strict=True)
        ]

    def _is_transforms(self, request: Request) -> bool:
        return request.role in ("poses", "headings") and is_tf(self._bag.topics[request.place])

    def _collector(self, request: Request) -> Collector:
        topic = self._bag.topics[request.place]
        texts: tuple[str, ...] = ()
        if request.role == "poses":
            wire = topic.layout(str(self.path))
            texts = tuple(f for f in FRAME_FIELDS if wire.has_text(f))
        return Collector(
            topic, request.paths, str(self.path), text_paths=texts, salvage=self._bag.salvage
        )

    def _from_samples(self, request: Request, samples: Samples, *, mixed: bool) -> Rows:
        """Rows of one request; in a topic of several signals those that have a pose. No command is a fault."""
        topic = self._bag.topics[request.place]
        stamps, clock = chosen_stamps(samples, request.spec.clock)
        keep: Mask = np.ones(len(stamps), dtype=bool)
        if isinstance(request.spec, PoseSource):
            if request.role == "poses":
                keep = of_one_frame(samples, request.spec, str(self.path))
            keep = keep & given_rows(samples.values) if mixed else keep
        stream = describe(
            request.role, topic.name, topic.type, clock=clock, stamps=stamps[keep],
            arrival=samples.arrival[keep], publishers=topic.publishers,
        )  # fmt: skip
        rows = Rows(stamps[keep], of_columns(samples.values[keep], request.columns), stream)
        if request.role != "commands":
            return rows
        return with_unknown_commands(rows, samples.arrival[keep], self._pauses)

    def _from_transforms(self, request: Request) -> Rows:
        spec, topic = self._vehicle.file.pose, self._bag.topics[request.place]
        if spec.parent is None or spec.child is None:
            raise RecordingError(
                f"{self._vehicle.source}: pose: topic {topic.name} carries transforms: name parent and child, "
                "for instance parent: map and child: base_link"
            )
        found = tf_pose(self._bag, topic.name, spec.parent, spec.child)
        stream = describe(
            request.role, topic.name, f"{topic.type} {spec.parent} -> {spec.child}", clock=Clock.HEADER,
            stamps=found.stamps, arrival=found.arrival,
        )  # fmt: skip
        eta = np.column_stack([found.values[:, :2], yaw(found.values[:, 3:])])
        # undefined before the first and after the last transform of the path
        known = np.isfinite(eta).all(axis=1)
        return Rows(found.stamps[known], eta[known], stream)

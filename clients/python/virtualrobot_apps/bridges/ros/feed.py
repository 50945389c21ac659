"""Feeds: streams of one watch, watched by a thread only while somebody reads what comes of them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence

from virtualrobot import Client
from virtualrobot.errors import VirtualRobotError
from virtualrobot.streams.sample import Sample
from virtualrobot.streams.streams import told_streams
from virtualrobot.streams.watch import StreamWatch

from virtualrobot_apps.bridges.ros.mapping.outputs import REST_NANOSECONDS, Output
from virtualrobot_apps.bridges.ros.messages.message import Message

_WAIT_SECONDS = 0.2
_AGAIN_SECONDS = 1.0


class Feed:
    """Topics that come of streams of one watch; `publish` gets name and message, in the thread that reads the watch."""

    def __init__(
        self,
        client: Client,
        outputs: Sequence[Output],
        publish: Callable[[str, Message], None],
        say: Callable[[str], None],
    ) -> None:
        """Watch nothing yet."""
        self._client, self._publish, self._say = client, publish, say
        self._outputs = list(outputs)
        self._wanted: set[str] = set()
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def topics(self) -> set[str]:
        """Names of its topics."""
        return {one.topic for one in self._outputs}

    def want(self, topic: str, wanted: bool) -> None:
        """Begin or end to tell a topic; the watch ends with the last one, and its sensor reads no more."""
        (self._wanted.add if wanted else self._wanted.discard)(topic)
        if self._wanted and self._thread is None:
            self._stop = threading.Event()
            name = f"feed of {topic}"
            self._thread = threading.Thread(target=self._run, args=(self._stop,), name=name, daemon=True)
            self._thread.start()
        elif not self._wanted:
            self.close()

    def close(self) -> None:
        """Tell no more; what is under way may still come."""
        self._stop.set()
        self._thread = None

    def _run(self, stop: threading.Event) -> None:
        names = list(dict.fromkeys(one.stream for one in self._outputs))
        said = ""
        while not stop.is_set():
            try:
                self._watch(names, stop)
            except VirtualRobotError as error:
                if not stop.is_set() and str(error) != said:
                    self._say(f"{names[0]} is not told: {error}; it is tried again each {_AGAIN_SECONDS:g} s")
                said = str(error)
            stop.wait(_AGAIN_SECONDS)

    def _watch(self, names: list[str], stop: threading.Event) -> None:
        of_stream = {name: [one for one in self._outputs if one.stream == name] for name in names}
        told: dict[str, Sample] = {}
        bad: set[str] = set()

        def is_wanted(output: Output) -> bool:
            # What is latched is told to the hub for those who come later, while the watch goes on anyway.
            return output.latched or output.topic in self._wanted

        def take(sample: Sample) -> None:
            if stop.is_set():
                return  # another thread tells it already, where somebody wanted it again
            for output in of_stream[sample.stream]:
                if is_wanted(output) and _is_due(output, told.get(output.topic), sample):
                    told[output.topic] = sample
                    self._tell(output, sample, bad)

        # Messages are made in the thread that reads, and of what nobody wants no samples are made.
        services = self._client.services
        with StreamWatch(
            services,
            told_streams(services, names),
            take=take,
            wanted=lambda name: any(map(is_wanted, of_stream[name])),
        ) as watch:
            while not stop.is_set():
                watch.next(_WAIT_SECONDS)  # raises what ends the watch

    def _tell(self, output: Output, sample: Sample, bad: set[str]) -> None:
        """Make a message of a sample; one that can't be made is said once, and the next one is tried again."""
        try:
            value = output.make(sample)
        except Exception as error:
            if output.topic not in bad:
                self._say(f"{output.topic}: a sample at {sample.time:g} s is left out: {type(error).__name__}: {error}")
            bad.add(output.topic)
            return
        if value is not None:
            self._publish(output.topic, Message(output.type, value, sample.nanoseconds))


def _is_due(output: Output, before: Sample | None, sample: Sample) -> bool:
    """Return whether a sample says something else than the one that was told, or that one is old enough."""
    if output.same is None or before is None or not 0 <= sample.nanoseconds - before.nanoseconds < REST_NANOSECONDS:
        return True
    return not output.same(before, sample)

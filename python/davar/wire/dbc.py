"""tools/davar.dbc for another base identifier, and for other channels than 0."""

import copy
from collections.abc import Sequence

from ..errors import BadInput
from . import frames as wire

LAST = 0x7FF  # standard identifiers have 11 bits


def moved(base: int, channels: Sequence[int]) -> str:
    """The text of a DBC for these channels. With more than one, the messages of channel n are
    called DAVAR_..._n."""
    database = wire.database_of(wire.DBC_PATH)
    messages, names = database.messages, [message.name for message in database.messages]
    database.messages[:] = [entry for number in channels for entry in copy.deepcopy(messages)]
    for index, message in enumerate(database.messages):
        number = channels[index // len(names)]
        message.frame_id += base - wire.BASE + wire.STEP * number
        message.name += f"_{number}" if len(channels) > 1 else ""
        if message.frame_id > LAST:
            raise BadInput(
                f"--channel: {number} does not fit into 11-bit identifiers from {base:X} on"
            )
    database.refresh()
    return database.as_dbc_string()

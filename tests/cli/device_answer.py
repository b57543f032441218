"""The words that a device writes for davar-sim --device (port/job/davar_job.h)."""

import struct

RESULT_HEAD, RESULT_REST = 23, 6 + 20
HEALTH = 2**64 - 1


def words(*values):
    return struct.pack(f"<{len(values)}Q", *values)


def head(*values):
    return words(*values, *[0] * (RESULT_HEAD - len(values)))


def result(channel=0, taus=1):
    return head(channel, 300, 600, 0, 0, 0, 0, 0, taus) + words(*[0] * RESULT_REST)

/** @file
 * davar - frames as SLCAN (Lawicel) text for a serial line: "t5D08", 16 hex digits, carriage
 * return.
 *
 * slcand, python-can and SavvyCAN read this text unchanged. No heap, no I/O, no state. */
#ifndef DAVAR_SLCAN_H
#define DAVAR_SLCAN_H

#include "davar/can.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DAVAR_SLCAN_BYTES 22U /**< a classical frame of 8 bytes: t, 3 + 1 + 16 digits, return */

/** Writes a classical frame (length <= 8, asserted) as text without a final zero.
 * `text` holds DAVAR_SLCAN_BYTES.
 * @return Number of characters, 6 + 2 length. Cost: O(length). */
size_t davar_slcan_encode(const davar_frame_t *frame, char *text);

/** Reads one line without its carriage return, in lower or upper case. Four more hex digits, a time
 * stamp, are accepted and ignored.
 * @return False if the line is not a standard data frame; *frame is then unspecified.
 *         Cost: O(length). */
bool davar_slcan_decode(const char *text, size_t length, davar_frame_t *frame);

#ifdef __cplusplus
}
#endif

#endif

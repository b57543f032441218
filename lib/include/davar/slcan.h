/* davar - frames as SLCAN (Lawicel) text, for a serial line: "t5D08" + 16 hex digits + carriage return.
 * slcand, python-can and SavvyCAN read it as it is. No heap, no I/O. */
#ifndef DAVAR_SLCAN_H
#define DAVAR_SLCAN_H

#include "davar/codec.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DAVAR_SLCAN_BYTES 22U /* t iii l dddddddddddddddd \r: a classical frame of 8 bytes */

/* Writes a classical frame (length <= 8; asserted) as text without a final zero; `text` holds DAVAR_SLCAN_BYTES. Returns
 * the number of characters, 6 + 2 length. */
size_t davar_slcan_encode(const davar_frame_t *frame, char *text);

/* Reads one line, without its carriage return. False: not a standard data frame; *frame is then unspecified. Lower and
 * upper case hex digits; four digits of an optional time stamp behind the data are accepted and ignored. */
bool davar_slcan_decode(const char *text, size_t length, davar_frame_t *frame);

#ifdef __cplusplus
}
#endif

#endif

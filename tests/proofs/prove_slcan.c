/* Statement: davar_slcan_decode, for any text of 0 to TEXT bytes, reads nothing after it, and
 * nothing overflows. An accepted frame has at most 8 bytes. Bound: TEXT; no accepted text is longer
 * than 25. */
#include "davar/slcan.h"

#include "proof.h"

#ifndef TEXT
#define TEXT 28U
#endif

/* `fifth`: the byte with the length of the data. */
static void decode(size_t length, char low, char high)
{
    char text[TEXT + 1U]; /* of which `length` are initialised: reading another is an alarm */
    davar_frame_t frame;
    any_bytes(text, length);
    if (length > 4U) {
        text[4] = Frama_C_char_interval(low, high);
    }
    if (davar_slcan_decode(text, length, &frame)) {
        PROVE(frame.length <= 8U);
    }
}

void prove(void)
{
    /* Every byte value: the digits one by one, ranges for the others. */
    for (size_t length = 0U; length <= TEXT; length++) {
        decode(length, CHAR_MIN, '0' - 1);
        for (char digit = '0'; digit <= '9'; digit++) {
            decode(length, digit, digit);
        }
        decode(length, '9' + 1, 'A' - 1);
        decode(length, 'A', 'F');
        decode(length, 'F' + 1, 'a' - 1);
        decode(length, 'a', 'f');
        decode(length, 'f' + 1, CHAR_MAX);
    }
    PROVED();
}

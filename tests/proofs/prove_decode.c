/* Statement: davar_decode, for any frame and any base, reads and writes inside its arguments, and
 * nothing overflows. Decoded indices stay inside the tables of davar/can_decode.h. All 64 data bytes,
 * the length and the identifier are arbitrary. No bound. */
#include "davar/can_decode.h"

#include "proof.h"

void prove(void)
{
    for (uint32_t message = 0U; message < DAVAR_CAN_STEP; message++) {
        davar_frame_t frame;
        davar_decoded_t wire;
        any_bytes(&frame, sizeof frame);
        const uint16_t base = (uint16_t)any_u32(0U, UINT16_MAX);
        const davar_decode_status_t status = davar_decode(&frame, base, &wire);
        if (status == DAVAR_DECODED) {
            PROVE((uint32_t)wire.message < (uint32_t)DAVAR_MESSAGE_COUNT);
            PROVE(wire.result <= 15U);
            PROVE((uint32_t)wire.noise <= (uint32_t)DAVAR_NOISE_FILTERED);
        }
    }
    PROVED();
}

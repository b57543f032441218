/* davar in Betaflight: its report as NAMED_VALUE_FLOAT, beside Betaflight's own MAVLink telemetry.
 *
 * One axis at a time, ten times a second: ARW_X, ARW_X_LO, ARW_X_HI in deg/sqrt(h), the same of the
 * floor as FLR_X and after the filters as ARWF_X, and ARW_ALARMS. Without a value, only its upper
 * limit is sent, if there is one. */
#include "davar_gyro.h"

#include "platform.h"

#ifdef USE_TELEMETRY_MAVLINK

#include "common/maths.h"
#include "common/printf.h"
#include "common/time.h"
#include "common/utils.h"
#include "drivers/serial.h"
#include "drivers/time.h"
#include "io/serial.h"
/* The generated headers of MAVLink have warnings. */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"
#include "common/mavlink.h"
#pragma GCC diagnostic pop

#define PERIOD_MS 100U
#define NAME_BYTES MAVLINK_MSG_NAMED_VALUE_FLOAT_FIELD_NAME_LEN

/* name: NAME_BYTES of them are sent. */
static void send(serialPort_t *port, const char *name, float value)
{
    static mavlink_message_t message;
    static uint8_t bytes[MAVLINK_MAX_PACKET_LEN];
    mavlink_msg_named_value_float_pack(0, 200, &message, millis(), name, value);
    const uint16_t length = mavlink_msg_to_send_buffer(bytes, &message);
    if (serialTxBytesFree(port) >= length) { /* otherwise the line is too slow: skip it */
        serialWriteBuf(port, bytes, length);
    }
}

/* `signal`: the start of the names, for example ARW. */
static void send_noise(serialPort_t *port, const char *signal, int axis,
                       const davar_gyro_noise_t *noise)
{
    static const char *const ends[] = {"", "_LO", "_HI"};
    const float values[] = {noise->value, noise->low, noise->high};
    const bool has[] = {noise->present, noise->present, noise->high > 0.0f};
    for (unsigned i = 0; i < ARRAYLEN(ends); i++) {
        char name[NAME_BYTES + 1U] = {0};
        tfp_sprintf(name, "%s_%c%s", signal, 'X' + axis, ends[i]);
        if (has[i]) {
            send(port, name, values[i]);
        }
    }
}

static serialPort_t *telemetry_port(void)
{
    const serialPortConfig_t *config = findSerialPortConfig(FUNCTION_TELEMETRY_MAVLINK);
    const serialPortUsage_t *usage =
        (config != NULL) ? findSerialPortUsageByIdentifier(config->identifier) : NULL;
    return (usage != NULL) ? usage->serialPort : NULL;
}

void davar_gyro_mavlink(void)
{
    static uint32_t last;
    static int axis;
    serialPort_t *port = telemetry_port();
    if ((port == NULL) || (millis() - last < PERIOD_MS)) {
        return;
    }
    last = millis();
    const davar_gyro_report_t *report = davar_gyro_report();
    send_noise(port, "ARW", axis, &report->sensor[axis]);
    send_noise(port, "FLR", axis, &report->floor[axis]);
    send_noise(port, "ARWF", axis, &report->filtered[axis]);
    send(port, "ARW_ALARMS", (float)report->alarms);
    axis = (axis + 1) % DAVAR_GYRO_AXES;
}

#endif

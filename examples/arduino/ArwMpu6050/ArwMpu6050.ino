/* davar example - the angle random walk of the z axis of an MPU-6050, once per second, as CSV on
 * the serial port.
 *
 * Wiring: SDA, SCL, 3.3 V, ground; AD0 low (address 0x68). The sensor samples on its own clock and
 * its FIFO holds 512 samples. No sample is lost if the sketch is busy for less than five seconds. A
 * longer pause is counted as a gap.
 *
 * Registers: InvenSense, "MPU-6000 and MPU-6050 Register Map and Descriptions", RM-MPU-6000A-00,
 * revision 4.2. Its register numbers are in the comments. Typical noise: 0.005 deg/s/sqrt(Hz)
 * (product specification PS-MPU-6000A-00, section 6.1), which is 0.3 deg/sqrt(h).
 *
 * The board needs a 64-bit double: any 32-bit board, but not an Uno or Mega with an AVR. */
#include <Wire.h>
#include <davar.h>

const uint8_t SENSOR = 0x68;
const uint8_t SMPLRT_DIV = 0x19;  /* 25: rate = 1 kHz / (1 + SMPLRT_DIV) while the low-pass is on */
const uint8_t CONFIG = 0x1A;      /* 26: DLPF_CFG 3: 42 Hz */
const uint8_t GYRO_CONFIG = 0x1B; /* 27: FS_SEL 0: +-250 deg/s, 131 counts per deg/s */
const uint8_t FIFO_EN = 0x23;     /* 35: bit 4: the gyro's z axis */
const uint8_t INT_STATUS = 0x3A;  /* 58: bit 4: the FIFO has overflowed; reading clears it */
const uint8_t USER_CTRL = 0x6A;   /* 106: bit 6: FIFO on, bit 2: empty it (while it is off) */
const uint8_t PWR_MGMT_1 =
    0x6B; /* 107: bit 6: sleep (set after power-up); CLKSEL 1: clock of the gyro */
const uint8_t FIFO_COUNT_H = 0x72; /* 114: bytes in the FIFO, two registers */
const uint8_t FIFO_R_W = 0x74;     /* 116 */
const uint8_t WHO_AM_I = 0x75;     /* 117: 0x68 */

const double RATE_HZ = 100.0;
const uint32_t taus[] = {1, 2, 4, 8, 16, 32, 64};
const int TAUS = 7;

static uint64_t memory[4096 / 8];
static davar_config_t config;
static davar_plan_t plan;
static davar_t gyro_z;
static davar_result_t result;

static void write_register(uint8_t address, uint8_t value)
{
    Wire.beginTransmission(SENSOR);
    Wire.write(address);
    Wire.write(value);
    Wire.endTransmission();
}

/* Requests `count` bytes, at most 32, beginning at a register. Returns the number received. */
static uint8_t request(uint8_t address, uint8_t count)
{
    Wire.beginTransmission(SENSOR);
    Wire.write(address);
    Wire.endTransmission(false);
    return (uint8_t)Wire.requestFrom(SENSOR, count);
}

static uint8_t read_register(uint8_t address)
{
    return request(address, 1) == 1 ? (uint8_t)Wire.read() : 0;
}

static int16_t read_word() /* the high byte comes first */
{
    const uint8_t high = (uint8_t)Wire.read();
    return (int16_t)((uint16_t)high << 8 | (uint8_t)Wire.read());
}

static void empty_fifo()
{
    write_register(USER_CTRL, 0x00);
    write_register(USER_CTRL, 0x04);
    write_register(USER_CTRL, 0x40);
}

static void start_sensor()
{
    write_register(PWR_MGMT_1, 0x01);
    write_register(CONFIG, 3);
    write_register(SMPLRT_DIV, 9);
    write_register(GYRO_CONFIG, 0x00);
    write_register(FIFO_EN, 0x10);
    delay(100); /* the gyro starts */
    empty_fifo();
    (void)read_register(INT_STATUS);
}

static davar_status_t start_davar()
{
    config = davar_default_config;
    config.rate_hz = RATE_HZ;
    config.unit_per_count = 1.0 / 131.0;
    config.law = NULL;
    config.stride = 100; /* one result per second */
    config.window.longest = 600;
    config.window.shortest = 600;
    config.moments.segment = 0;
    config.taus = taus;
    config.tau_count = TAUS;
    davar_filter_t filter = {};
    davar_filter_low_pass(&filter, 42.0 / RATE_HZ, 2, 0.1); /* register CONFIG; known to 10 % */
    davar_plan_init_filtered(&plan, taus, TAUS, &filter);
    return davar_init_q15(&gyro_z, &config, memory, sizeof memory);
}

static void stop(const char *why)
{
    for (;;) {
        Serial.println(why);
        delay(1000);
    }
}

static void print_result()
{
    davar_fit(&plan, config.rate_hz, &result);
    const davar_coefficient_t *arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
    Serial.print((unsigned long)result.window_samples);
    Serial.print(",");
    Serial.print(arw->value, 4);
    Serial.print(",");
    Serial.print(arw->low, 4);
    Serial.print(",");
    Serial.print(arw->high, 4);
    Serial.print(",");
    Serial.println((unsigned long)davar_health(&gyro_z).gaps);
}

void setup()
{
    Serial.begin(115200);
    Wire.begin();
    Wire.setClock(400000);
    if (read_register(WHO_AM_I) != 0x68) {
        stop("no MPU-6050 at 0x68");
    }
    const davar_status_t status = start_davar();
    if (status != DAVAR_OK) {
        stop(davar_status_text(status));
    }
    start_sensor();
    Serial.println("window_samples,arw_deg_per_sqrt_h,arw_low,arw_high,gaps");
}

void loop()
{
    if (read_register(INT_STATUS) &
        0x10) { /* its content no longer begins with the first byte of a sample */
        empty_fifo();
        davar_gap(&gyro_z, 1); /* the number of lost samples is unknown */
        return;
    }
    if (request(FIFO_COUNT_H, 2) != 2) {
        return;
    }
    uint16_t waiting = (uint16_t)read_word() / 2;
    int16_t counts[16];
    if (waiting > 16) {
        waiting = 16;
    }
    if (waiting == 0 || request(FIFO_R_W, (uint8_t)(2 * waiting)) != 2 * waiting) {
        return;
    }
    for (uint16_t i = 0; i < waiting; i++) {
        counts[i] = read_word();
    }
    for (size_t done = 0; done < waiting;) {
        done += davar_push_until_result_q15(&gyro_z, counts + done, waiting - done);
        if (davar_take(&gyro_z, &result)) {
            print_result();
        }
    }
}

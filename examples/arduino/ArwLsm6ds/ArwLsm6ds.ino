/* davar example - the angle random walk of the z axis of an LSM6DS, once per second, as CSV on the
 * serial port.
 *
 * For the LSM6DS3, LSM6DS3TR-C, LSM6DSL, LSM6DSO and LSM6DSOX. The registers used here are equal in
 * all of them (their FIFOs are not). Wiring: SDA, SCL, 3.3 V, ground; SA0 low (address 0x6A) or
 * high (0x6B). The sketch polls the sensor. If it polls too late for a sample, its clock shows
 * this, and the loss is counted as a gap.
 *
 * Registers: STMicroelectronics, data sheets DS12140 (LSM6DSO) and DocID026899 (LSM6DS3), "Register
 * description".
 *
 * The board needs a 64-bit double: any 32-bit board, but not an Uno or Mega with an AVR. */
#include <Wire.h>
#include <davar.h>

/* 0x69 LSM6DS3, 0x6A LSM6DSL and LSM6DS3TR-C, 0x6C LSM6DSO and LSM6DSOX */
const uint8_t WHO_AM_I = 0x0F;
const uint8_t CTRL2_G = 0x11; /* ODR_G 0100: 104 Hz; FS_G 00: +-250 deg/s, 8.75 mdeg/s per count */
/* bit 6, BDU: the two bytes of a value are from one sample; bit 2, IF_INC: the register address
 * increments while reading */
const uint8_t CTRL3_C = 0x12;
/* bit 1, GDA: a gyro sample is waiting; reading its high byte clears the bit */
const uint8_t STATUS_REG = 0x1E;
const uint8_t OUTZ_L_G = 0x26; /* low byte, then high byte */

const double RATE_HZ = 104.0;
const uint32_t PERIOD_US = 9615;
const uint32_t taus[] = {1, 2, 4, 8, 16, 32, 64};
const int TAUS = 7;

static uint64_t memory[4096 / 8];
static davar_config_t config;
static davar_plan_t plan;
static davar_t gyro_z;
static davar_result_t result;
static uint8_t sensor; /* its address */
static uint32_t last_us;

static void write_register(uint8_t address, uint8_t value)
{
    Wire.beginTransmission(sensor);
    Wire.write(address);
    Wire.write(value);
    Wire.endTransmission();
}

static uint8_t request(uint8_t address, uint8_t count)
{
    Wire.beginTransmission(sensor);
    Wire.write(address);
    Wire.endTransmission(false);
    return (uint8_t)Wire.requestFrom(sensor, count);
}

static uint8_t read_register(uint8_t address)
{
    return request(address, 1) == 1 ? (uint8_t)Wire.read() : 0;
}

static bool find_sensor()
{
    for (sensor = 0x6A; sensor <= 0x6B; sensor++) {
        const uint8_t name = read_register(WHO_AM_I);
        if (name == 0x69 || name == 0x6A || name == 0x6C) {
            return true;
        }
    }
    return false;
}

static davar_status_t start_davar()
{
    config = davar_default_config;
    config.rate_hz = RATE_HZ;
    config.unit_per_count = 0.00875;
    config.law = NULL;
    config.stride = 104; /* one result per second */
    config.window.longest = 624;
    config.window.shortest = 624;
    config.moments.segment = 0;
    config.taus = taus;
    config.tau_count = TAUS;
    davar_filter_t filter = {};
    davar_filter_low_pass(&filter, 33.0 / RATE_HZ, 2, 0.1); /* at 104 Hz; known to 10 % */
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
    if (!find_sensor()) {
        stop("no LSM6DS at 0x6A or 0x6B");
    }
    const davar_status_t status = start_davar();
    if (status != DAVAR_OK) {
        stop(davar_status_text(status));
    }
    write_register(CTRL3_C, 0x44);
    write_register(CTRL2_G, 0x40);
    delay(100); /* the gyro starts; its first samples are not valid */
    (void)request(OUTZ_L_G, 2);
    last_us = micros();
    Serial.println("window_samples,arw_deg_per_sqrt_h,arw_low,arw_high,gaps");
}

void loop()
{
    if (!(read_register(STATUS_REG) & 0x02) || request(OUTZ_L_G, 2) != 2) {
        return;
    }
    const uint8_t low = (uint8_t)Wire.read();
    const int16_t count = (int16_t)((uint16_t)(uint8_t)Wire.read() << 8 | low);
    const uint32_t now_us = micros();
    const uint32_t periods = (now_us - last_us + PERIOD_US / 2) / PERIOD_US;
    last_us = now_us;
    if (periods > 1) {
        davar_gap(&gyro_z, periods - 1);
    }
    davar_push_q15(&gyro_z, &count, 1);
    if (davar_take(&gyro_z, &result)) {
        print_result();
    }
}

/* A small Arduino core: the part of the interface that davar's sketches use. Time passes with the
 * I2C bytes and in delay. */
#ifndef ARDUINO_H
#define ARDUINO_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

void setup();
void loop();
uint32_t micros();
void delay(uint32_t milliseconds);

struct HardwareSerial {
    void begin(unsigned long) {}
    void print(const char *text)
    {
        printf("%s", text);
    }
    void print(unsigned long number)
    {
        printf("%lu", number);
    }
    void print(double number, int digits)
    {
        printf("%.*f", digits, number);
    }
    void println(const char *text)
    {
        printf("%s\n", text);
    }
    void println(unsigned long number)
    {
        printf("%lu\n", number);
    }
};
extern HardwareSerial Serial;

/* I2C, with one sensor on the bus. */
class TwoWire {
  public:
    void begin() {}
    void setClock(uint32_t) {}
    void beginTransmission(uint8_t address);
    size_t write(uint8_t value);
    uint8_t endTransmission(bool stop = true);
    uint8_t requestFrom(uint8_t address, uint8_t count);
    int available();
    int read();

  private:
    uint8_t address_, out_[32], in_[32];
    uint8_t out_count_, in_count_, in_next_;
};
extern TwoWire Wire;

#endif

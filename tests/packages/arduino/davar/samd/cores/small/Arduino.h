/* A small Arduino core: the part of the interface that davar's sketches use. Time passes with the
 * I2C bytes and in delay. */
#ifndef ARDUINO_H
#define ARDUINO_H

#include <stddef.h>
#include <stdint.h>

void setup();
void loop();
uint32_t micros();
void delay(uint32_t milliseconds);

class HardwareSerial {
  public:
    void begin(unsigned long baud);
    void print(const char *text);
    void print(unsigned long number);
    void print(double number, int digits);
    void println(const char *text);
    void println(unsigned long number);
};
extern HardwareSerial Serial;

#endif

/* Arduino's I2C, with one sensor on the bus: sensor.cpp. */
#ifndef WIRE_H
#define WIRE_H

#include <stddef.h>
#include <stdint.h>

class TwoWire {
  public:
    void begin();
    void setClock(uint32_t hertz);
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

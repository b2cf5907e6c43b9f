#pragma once
// What the sketches of an export use of Arduino's core, declared only.
#include <stdint.h>
#define A0 14
int analogRead(uint8_t pin);
unsigned long micros(void);
struct Printer {
    void begin(unsigned long baud);
    void print(const char *text);
    void print(double value);
    void println(double value);
};
extern Printer Serial;

#pragma once
#include <stdbool.h>
struct device { const char *name; };
extern const struct device chosen_canbus;
#define DT_CHOSEN(name) name
#define DEVICE_DT_GET(node) (&chosen_canbus)
bool device_is_ready(const struct device *dev);

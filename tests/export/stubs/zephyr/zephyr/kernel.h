#pragma once
/* What the samples of an export use of Zephyr's kernel, declared only. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#define ARG_UNUSED(x) (void)(x)
typedef struct { int64_t ticks; } k_timeout_t;
#define K_NSEC(t) ((k_timeout_t){(t) / 100000})
#define K_NO_WAIT ((k_timeout_t){0})
struct k_msgq { int used; };
int k_msgq_get(struct k_msgq *queue, void *data, k_timeout_t timeout);
int64_t k_uptime_ticks(void);
uint64_t k_ticks_to_ns_floor64(uint64_t ticks);
int32_t k_msleep(int32_t ms);

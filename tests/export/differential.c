/* Runs what tests/export/differential.py writes to it on an exported finger, and tells what became of it. */
#include "vg_finger.h"

#include <stdio.h>
#include <string.h>

#define FINGERS_HERE 2

typedef struct {
    int64_t first, second; /* arrival and now [ns]; or hand and number */
    double value;
    int32_t what, finger, length, name;
    uint8_t data[64];
} order;

typedef struct {
    int64_t result;
    uint64_t reals, wholes, grasp, other;
    uint8_t command[VG_COMMAND_BYTES];
} answer;

static vg_finger fingers[FINGERS_HERE];
static vg_grasp grasp;

static uint64_t word_of(double number)
{
    uint64_t word = 0x7FF8000000000000U;
    if (number == number) {
        memcpy(&word, &number, sizeof word);
    }
    return word;
}

static uint64_t digest(const double *numbers, int32_t count)
{
    uint64_t sum = 0U;
    for (int32_t i = 0; i < count; i++) {
        sum += word_of(numbers[i]) * (2U * (uint64_t)i + 1U);
    }
    return sum;
}

static uint64_t digest_of_wholes(const int64_t *numbers)
{
    uint64_t sum = 0U;
    for (int32_t i = 0; i < VG_WHOLES; i++) {
        sum += (uint64_t)numbers[i] * (2U * (uint64_t)i + 1U);
    }
    return sum;
}

int main(void)
{
    static double saved[VG_SAVED], given[VG_SAVED];
    order o;
    vg_grasp_init(&grasp);
    while (fread(&o, sizeof o, 1, stdin) == 1) {
        vg_finger *const e = &fingers[o.finger];
        answer a;
        memset(&a, 0, sizeof a);
        switch (o.what) {
        case 0: a.result = vg_init(e, (int32_t)o.first, (int32_t)o.second); break;
        case 1: {
            uint8_t exact[64]; /* at the end of what may be read, so that a byte too many is seen */
            uint8_t *const data = exact + sizeof exact - (o.length > 0 ? o.length : 0);
            memcpy(data, o.data, (size_t)(o.length > 0 ? o.length : 0));
            a.result = vg_frame(e, &grasp, data, o.length, o.first, o.second);
            break;
        }
        case 2: a.result = vg_tick(e, &grasp, o.second); break;
        case 3: a.result = vg_set(e, (vg_setting)o.name, o.value); break;
        case 4:
            vg_save(e, saved);
            a.other = digest(saved, VG_SAVED);
            break;
        default:
            if (fread(given, sizeof given, 1, stdin) != 1) {
                return 1;
            }
            a.result = vg_load(e, given);
        }
        memcpy(a.command, e->command, sizeof a.command);
        a.reals = digest(e->f.all, VG_REALS);
        a.wholes = digest_of_wholes(e->t.all);
        a.grasp = digest(grasp.needs, VG_FINGERS);
        if (fwrite(&a, sizeof a, 1, stdout) != 1 || fflush(stdout) != 0) {
            return 1;
        }
    }
    return 0;
}

/* The steps of all fingers, one row of a batch or packet after the other; vegrip/grip/compiled_rows.py calls
 * it. It stands below the text of the kernels, which have no words for pointers to pointers.
 *
 * A row has four numbers: its finger (negative: none of ours), where in the data its frame begins, how long it
 * is, and when it arrived [ns]. A command is packed behind the head of its finger. With stops nothing behind a
 * row that is left alone is looked at. Returns how many commands there are.
 */
int64_t vg_rows_step(double *const *f, int64_t *const *t, double *g, const uint8_t *heads, int64_t head,
    int64_t command, int64_t commanded, const uint8_t *data, const int64_t *rows, int64_t count, int64_t stops,
    int64_t now, uint8_t *answers, uint8_t *done)
{
    int64_t commands = 0;
    for (int64_t i = 0; i < count; i++, rows += 4) {
        const int64_t n = rows[0];
        uint8_t *answer = answers + commands * (head + command);
        done[i] = 0;
        if (n >= 0) {
            done[i] = (uint8_t)vg_finger_step(f[n], t[n], g, data + rows[1], rows[2], rows[3], now, answer + head);
        }
        if (done[i] & commanded) {
            for (int64_t k = 0; k < head; k++) {
                answer[k] = heads[n * head + k];
            }
            commands++;
        }
        if (stops && done[i] == 0) {
            break;
        }
    }
    return commands;
}

/* Prints the checksum of the first so many bytes of a pattern, for each count and seed on standard input. */
#define RBT_WRITER_IMPLEMENTATION
#include "../../contrib/rbt_writer.h"

int main(void) {
    static uint8_t data[1 << 14];
    unsigned long count, seed, i;
    for (i = 0; i < sizeof data; i++) data[i] = (uint8_t)(i * i % 251);
    while (scanf("%lu %lu", &count, &seed) == 2) {
        uint64_t hash = rbt_hash(data, count, seed);
        printf("%08lx%08lx\n", (unsigned long)(hash >> 32), (unsigned long)(hash & UINT32_MAX));
    }
    return 0;
}

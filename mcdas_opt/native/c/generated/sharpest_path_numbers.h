/* Generated: the numbers of `reference.offset_path`. */
#define ALONG 129
#define AROUND 97
#define ROUNDS 3
#define TRIED 9

// INLINE: for functions whose call would cost more than what they do.
#pragma once

#if defined(__GNUC__)
#define INLINE [[gnu::always_inline]] inline
#else
#define INLINE __forceinline
#endif

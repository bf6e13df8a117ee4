#ifdef __cplusplus
}
#endif

#endif /* MOTORCADE_SMOOTH_H */

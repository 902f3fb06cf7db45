// The package imports folders and files without their endings, as bundlers allow and Node does not.
export async function resolve(specifier, context, next) {
  try {
    return await next(specifier, context);
  } catch (error) {
    if (!specifier.startsWith('.')) throw error;
    for (const ending of ['.js', '/index.js']) {
      try {
        return await next(specifier + ending, context);
      } catch {
        // The next one.
      }
    }
    throw error;
  }
}

# docker build -t gelcone . && docker run --rm -v "$PWD:/home/user/work" gelcone simulate biased-pump --out results
# It has not been built yet, see RELEASING.md.
FROM python:3.13-slim
RUN useradd --create-home user && install --directory --owner=user /home/user/work
COPY --chown=user . /home/user/source
RUN pip install --no-cache-dir "/home/user/source[studio,fem,cluster,parquet]" && rm -r /home/user/source
USER user
WORKDIR /home/user/work
RUN gelcone simulate biased-pump --film wrinkling --periods 1
ENTRYPOINT ["gelcone"]
CMD ["--help"]

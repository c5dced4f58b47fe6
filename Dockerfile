# seatrial without a compiler in the image. Not built by the project's tests.
#   docker build -t seatrial .
#   docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/work" seatrial auto run1.bag -o my-boat
FROM python:3.12-slim AS build
RUN apt-get update && apt-get install -y --no-install-recommends g++ && rm -rf /var/lib/apt/lists/*
COPY . /src
RUN pip wheel --no-cache-dir --no-deps --wheel-dir /wheels /src

FROM python:3.12-slim
RUN --mount=type=bind,from=build,source=/wheels,target=/wheels \
  pip install --no-cache-dir "$(ls /wheels/seatrial-*.whl)[ardupilot,mat,parquet]" && useradd --create-home boat
USER boat
WORKDIR /work
ENTRYPOINT ["seatrial"]
